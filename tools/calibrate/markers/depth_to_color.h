#pragma once

// Where a sensor's colour camera stands to its depth camera, for sensors whose driver does not register: from markers
// that both see, since their dark cells are of a material (aluminium foil, thesis 3.1) that returns no depth. Pixels
// without depth make a picture in which the markers can be found.
//
// Thread: pure functions.

#include <span>
#include <string>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/rigid3.h"
#include "common/result.h"

namespace copresence::calibrate {

/// 255 where every frame has depth, 0 where none has. Requires frames of one size.
Image<std::uint8_t> depth_presence(std::span<const RgbdFrame> frames);

struct DepthToColor {
  Rigid3 color_from_depth;  ///< metres
  double rms_px = 0;        ///< of the markers' corners, measured in depth, shown in the colour picture
  double worst_px = 0;
  double expected_shift_m = 0;  ///< standard deviation of a point among the markers
  int markers = 0;
};

/// frames  as delivered: depth and colour each in its own camera.
/// Fails   kInvalid: too few markers seen by both, or lying badly.
Result<DepthToColor> fit_depth_to_color(std::span<const RgbdFrame> frames, DepthUnit unit,
                                        const CameraModel& depth, const CameraModel& color,
                                        const std::string& dictionary);

}  // namespace copresence::calibrate
