#pragma once

// Which images of a folder are depth, which are colour, and when each was taken: public RGB-D sets are folders.

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/record/time_reading.h"

namespace copresence::record {

struct TimedImage {
  std::filesystem::path path;
  std::chrono::microseconds
      time{};  ///< since 1970 where ImageFolder::since_1970, else from the set's own zero
  friend bool operator==(const TimedImage&, const TimedImage&) = default;
};

/// Each stream by rising time.
struct ImageFolder {
  std::vector<TimedImage> depth, color;
  bool has_tum_depth = false;  ///< by TUM's lists, whose depth is 5000 to a metre
  TimeUnit unit = TimeUnit::kFrames;
  bool since_1970 = false;
  /// Sentences for the user: what was taken, what was left, and what the times were taken for.
  std::vector<std::string> remarks;
};

/// What decides where a folder leaves a choice.
struct FolderChoice {
  double frames_per_second = 30;       ///< of frame numbers
  std::optional<TimeUnit> times = {};  ///< recognised where not given
  std::string depth = {}, color = {};  ///< a folder or a label of ImageGroup; the likeliest where empty
};

/// The folder's images. Their times and pairs come from associations.txt or the like, else from depth.txt and rgb.txt or
/// color.txt, else from names: a date, a time in some unit (recognise_times()), or a frame's number.
/// Fails  kNotFound (no such folder, an image that a list names, no depth), kInvalid (a line that is none, times or
///        groups of images that can be read in two ways).
Result<ImageFolder> find_images(const std::filesystem::path& folder, const FolderChoice& choice);

}  // namespace copresence::record
