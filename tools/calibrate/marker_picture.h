#pragma once

// What a camera saw and what became of it, as a picture to look at before trusting the numbers.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"
#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/markers/camera_sightings.h"
#include "tools/calibrate/markers/found_marker.h"

namespace copresence::calibrate {

struct MarkedPicture {
  std::string camera;
  ColorImage picture;
  std::vector<FoundMarker> markers;
  std::vector<MarkerDepth> depths;
};

/// The cameras' pictures, two in a row, each marker outlined and named with its distance and how far off the common
/// place this camera puts it. Green up to 10 mm, yellow to 30 mm, red beyond or where it could not be used.
/// Fails  kUnavailable where the file cannot be written, kInvalid for an ending that is no picture's.
Result<void> write_marked_pictures(std::span<const MarkedPicture> cameras, const calibration::Names& names,
                                   std::span<const calibration::Sighting> sightings,
                                   const calibration::WorldFit& fit, const std::filesystem::path& file);

}  // namespace copresence::calibrate
