#pragma once

// Finds the pose of a sensor's colour camera relative to its depth camera, for sensors whose colour
// is not registered. The markers' dark cells are aluminium foil (thesis 3.1), which returns no
// depth. So the markers are visible in a picture of the pixels without depth.
// Thread: pure functions.

#include <cstdint>
#include <string>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/markers/marker_finder.h"

namespace copresence::calibrate {

struct DepthToColor {
  Rigid3 color_from_depth;  ///< Transform from the depth to the colour camera, metres.
  double rms_px = 0;        ///< Reprojection error of the corners in the colour picture.
  double worst_px = 0;
  double expected_shift_m = 0;  ///< Standard deviation of a point among the markers, metres.
  int markers = 0;
};

/// Collects frames of a still scene, with depth and colour each in its own camera. Keeps sums
/// instead of frames. Thread: one thread per object.
class DepthToColorFinder {
 public:
  /// Fails with kInvalid for an unknown dictionary.
  static Result<DepthToColorFinder> open(DepthUnit unit, const std::string& dictionary, int border_bits);

  /// Requires an image of the same size as the first one.
  void add_depth(const DepthImage& depth);
  /// Searches for markers, which takes longer than add_depth(). About twenty pictures are enough.
  void add_color(const ColorImage& color) { in_color_.add(color); }

  /// Requires depth. Fails with kInvalid for too few common markers or a bad layout.
  Result<DepthToColor> fit(const CameraModel& depth, const CameraModel& color) const;

 private:
  DepthToColorFinder(DepthUnit unit, MarkerFinder finder)
      : average_(unit), in_color_(finder), in_depth_(std::move(finder)) {}

  DepthAverage average_;
  Image<std::uint16_t> measured_;     // Number of frames with depth, by pixel.
  MarkerFinder in_color_, in_depth_;  // `in_depth_` stays empty until fit().
};

}  // namespace copresence::calibrate
