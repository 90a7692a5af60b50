#pragma once

// Creates a recording from a folder of images.

#include <cstdint>
#include <string>
#include <vector>

#include "capture_server/recording/oni_repair.h"
#include "common/result.h"
#include "tools/record/settings.h"

namespace copresence::record {

struct FromImagesReport {
  std::size_t depth_frames = 0, color_frames = 0;
  std::uint64_t bytes = 0;
  /// Number of depth pixels beyond the range of the unit, which became holes.
  std::uint64_t too_far = 0;
  double depth_per_metre = 0;  ///< Pixel value of one metre; 0 for raw disparities.
  std::vector<std::string>
      remarks;  ///< Messages for the user: images used, images left out, and assumptions.
};

/// Reads the images in the order of their times and writes a recording. JPEG files are copied
/// unchanged. The recording is then checked as capture_server checks it, and removed if it fails.
/// Fails as find_images() does. Fails with kCorrupt or kInvalid for an unsuitable image, for a
/// recording that could not be played, or for an existing file without `overwrite`. Fails with
/// kUnavailable if writing fails.
Result<FromImagesReport> make_from_images(const FromImagesSettings& settings,
                                          const recording::ProgressReport& progress);

}  // namespace copresence::record
