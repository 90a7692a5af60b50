#pragma once

// What comes back of a Kinect's projected dots to its infrared camera, before anything random. The projector stands 75 mm to the
// camera's right: left of what is near, f b (1/z_near - 1/z_far) pixels of what is behind get no dots.
//
// Thread: free functions on values, safe anywhere.

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "simulation/true_view.h"

namespace copresence::simulation {

inline constexpr double kProjectorBaseline = 0.075;  // metres
/// Metres: the depth of disparity level k is this over k.
inline constexpr double kLevelConstant = kKinectV1Noise.disparity_constant_m;

/// Width in pixels of the shadow that something at z_near throws on something at z_far, metres.
constexpr double shadow_width_px(double fx, double z_near, double z_far) {
  return fx * kProjectorBaseline * (1 / z_near - 1 / z_far);
}

/// Of one pixel.
struct Dots {
  float level = 0;  ///< exact disparity, see kLevelConstant; 0 in the projector's shadow
  float light = 0;  ///< falls with distance, though automatic gain gives most of it back to what is far
  friend bool operator==(const Dots&, const Dots&) = default;
};
using DotImage = Image<Dots>;

/// Requires a view of the model's size.
void project_dots(const CameraModel& model, const TrueView& view, DotImage& dots);

}  // namespace copresence::simulation
