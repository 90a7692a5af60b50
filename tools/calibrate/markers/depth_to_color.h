#pragma once

// Where a sensor's colour camera stands to its depth camera, for sensors whose driver does not register: from markers
// that both see, since their dark cells are of a material (aluminium foil, thesis 3.1) that returns no depth. Pixels
// without depth make a picture in which the markers can be found.
//
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
  Rigid3 color_from_depth;  ///< metres
  double rms_px = 0;        ///< of the markers' corners, measured in depth, shown in the colour picture
  double worst_px = 0;
  double expected_shift_m = 0;  ///< standard deviation of a point among the markers
  int markers = 0;
};

/// Collects frames of a still scene, as delivered: depth and colour each in its own camera. Keeps sums, no frames.
/// Thread: one thread per object.
class DepthToColorFinder {
 public:
  /// Fails  kInvalid for a dictionary that there is not.
  static Result<DepthToColorFinder> open(DepthUnit unit, const std::string& dictionary, int border_bits);

  /// Requires images of the first one's size.
  void add_depth(const DepthImage& depth);
  /// Looks for markers, which takes longer: about twenty pictures are enough.
  void add_color(const ColorImage& color) { in_color_.add(color); }

  /// Fails  kInvalid: too few markers seen by both, or lying badly. Requires depth.
  Result<DepthToColor> fit(const CameraModel& depth, const CameraModel& color) const;

 private:
  DepthToColorFinder(DepthUnit unit, MarkerFinder finder)
      : average_(unit), in_color_(finder), in_depth_(std::move(finder)) {}

  calibration::DepthAverage average_;
  Image<std::uint16_t> measured_;     // number of frames with depth, by pixel
  MarkerFinder in_color_, in_depth_;  // the latter still empty
};

}  // namespace copresence::calibrate
