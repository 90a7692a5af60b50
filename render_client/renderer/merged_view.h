#pragma once

// What the virtual camera sees: the scene of all cameras, merged.

#include <cstdint>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"

namespace copresence::renderer {

/// The eye: a pin-hole without distortion (an off-centre cx, cy is an off-axis projection) at a pose.
struct VirtualCamera {
  CameraModel lens;
  Rigid3 world_from_eye;  ///< camera convention: x right, y down, z forward; metres
  double near_m = 0.1;    ///< nothing nearer or farther is shown
  double far_m = 10.0;
};

/// The lens of a view of this size. `fov_degrees` is vertical, in (0, 180). The principal point follows the rule of
/// common/frame/camera_model.h, as a sensor's does.
CameraModel lens_from_fov(int width, int height, double fov_degrees);

inline constexpr std::uint8_t kNoCamera = 255;  ///< in MergedView::camera where nothing is shown

/// What a caller wants as host pixels; the rest stays where the renderer made it.
struct HostPixels {
  bool color = false;
  bool depth = false;  ///< depth, camera and quality
};

struct MergedView {
  int width = 0;
  int height = 0;
  Image<Rgba8> color;          ///< black with a = 0 where nothing is shown; empty unless asked for
  Image<float> depth_m;        ///< along the eye's axis; 0 where nothing is shown; empty unless asked for
  Image<std::uint8_t> camera;  ///< index of the camera that won the pixel, kNoCamera where none
  Image<float> quality;        ///< its quality index, cos(theta) / z^2 (thesis eq. 2.5), 1/m^2
  std::uint32_t texture =
      0;  ///< GL name of an RGBA8 texture with the colour, rows from the top; 0 for the CPU renderer
};

}  // namespace copresence::renderer
