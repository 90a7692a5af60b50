#pragma once

// Finds the depth and colour images of a folder and their times. Public data sets are such folders.

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
      time{};  ///< Time since 1970 if ImageFolder::since_1970, otherwise since any zero.
  friend bool operator==(const TimedImage&, const TimedImage&) = default;
};

/// The images of each stream in ascending order of time.
struct ImageFolder {
  std::vector<TimedImage> depth, color;
  bool has_tum_depth = false;  ///< True if depth has 5000 units per metre, as in TUM's data sets.
  TimeUnit unit = TimeUnit::kFrames;
  bool since_1970 = false;
  /// Messages for the user: images used and left out, and the unit of the times.
  std::vector<std::string> remarks;
};

struct FolderChoice {
  double frames_per_second = 30;       ///< Converts frame numbers to times.
  std::optional<TimeUnit> times = {};  ///< Unit of the times; recognised if not given.
  std::string depth = {}, color = {};  ///< Folder or label of an ImageGroup; chosen automatically if empty.
};

/// Finds the images. Times and pairs are read from associations.txt or a similar name, from
/// depth.txt and rgb.txt or color.txt, or from file names: a date, a time (recognise_times()) or a
/// frame number.
/// Fails with kNotFound if the folder, an image in a list, or all depth is missing. Fails with
/// kInvalid for a list that cannot be read, and for ambiguous times or groups of images.
Result<ImageFolder> find_images(const std::filesystem::path& folder, const FolderChoice& choice);

}  // namespace copresence::record
