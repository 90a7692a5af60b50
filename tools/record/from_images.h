#pragma once

// A recording made of a folder of images.

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
  std::uint64_t too_far = 0;         ///< depth pixels beyond what the unit holds, which are holes now
  double depth_per_metre = 0;        ///< 0 where the images hold a Kinect's raw disparities
  std::vector<std::string> remarks;  ///< sentences for the user: what was taken, left out and assumed
};

/// Reads the images in the order of their times and writes them. JPEGs go in unchanged. The written recording is checked
/// as capture_server checks it; one that fails is removed.
/// Fails  as find_images(); kCorrupt, kInvalid: an image that is not what it should be, a recording that could not be
///        played, an existing file without `overwrite`; kUnavailable: disk.
Result<FromImagesReport> make_from_images(const FromImagesSettings& settings,
                                          const recording::ProgressReport& progress);

}  // namespace copresence::record
