#pragma once

// Reads lists of images with their times, as in TUM's RGB-D data sets: "time file", or pairs "time
// file time file". Accepts variants that other tools and editors write.
// Thread: free functions; concurrent calls are safe.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/record/time_reading.h"

namespace copresence::record {

struct ListedImage {
  TimeNumber time;
  std::filesystem::path path;
};

/// The images of both streams in the order of the lists.
struct ListedStreams {
  std::vector<ListedImage> depth, color;
  bool has_tum_depth = false;  ///< True if depth has 5000 units per metre, as in TUM's data sets.
};

/// Reads the lists of a folder: associations.txt or a similar name, otherwise depth.txt and rgb.txt
/// or color.txt. Returns nothing if there are no lists. Adds the names of the lists to `remarks`.
///
/// Fields are separated by white space, commas or semicolons. A name is relative to the folder. A
/// name may be quoted, and may contain spaces if it ends with an image extension. These are
/// ignored: comment lines with #, a byte order mark, a header line, Windows line ends and
/// additional fields.
/// Fails with kInvalid and the line's number for a line that cannot be read. Fails with kNotFound
/// if an image or a list of depth is missing.
Result<std::optional<ListedStreams>> read_lists(const std::filesystem::path& folder,
                                                std::vector<std::string>& remarks);

}  // namespace copresence::record
