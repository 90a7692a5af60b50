#pragma once

// Which images of a folder are depth, which are colour, and when each was taken: public RGB-D sets are folders.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::record {

struct TimedImage {
  std::filesystem::path path;
  double time_s = 0;
  friend bool operator==(const TimedImage&, const TimedImage&) = default;
};

/// Each by rising time.
struct ImageFolder {
  std::vector<TimedImage> depth, color;
  bool has_lists = false;  ///< TUM's: times and pairs come from them
};

/// The folder's images: by associations.txt, else by depth.txt and rgb.txt, else by name. In names the last group of
/// digits counts frames, at `frames_per_second`; a name that is a number of seconds ("1305031102.175304.png") is a time. Lists
/// give seconds, or count frames where all their times are whole numbers below a million (ICL-NUIM's do).
/// Fails  kNotFound (no such folder, an image that a list names, no depth image), kInvalid (a list's line that is none).
Result<ImageFolder> find_images(const std::filesystem::path& folder, double frames_per_second);

/// The lines of one of TUM's lists: "time file", comments begin with #. `name` stands for it in sentences.
Result<std::vector<TimedImage>> parse_list(std::string_view text, const std::filesystem::path& folder,
                                           const std::string& name);

/// The lines of a file of pairs: "time file time file", colour first or depth first.
Result<ImageFolder> parse_associations(std::string_view text, const std::filesystem::path& folder,
                                       const std::string& name);

}  // namespace copresence::record
