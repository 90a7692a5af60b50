#pragma once

// What a Kinect v1 makes of true depth: levels of an eighth of a pixel of disparity, correlated errors,
// ragged edges, shadows of its projector, and holes.
//
//   levels        a Kinect knows only z = 351.3 m / k for whole k; 632 of them lie between 0.5 m and 5 m
//   errors        of the disparity before rounding: a fixed pattern per camera and a part that changes with
//   each frame,
//                 both alike over several pixels, since the sensor correlates windows; together half a level
//   edges         depth is taken from up to a pixel beside, differently in each frame
//   shadow        the projector stands 75 mm to the camera's right: left of what is near, f b (1/z_near -
//   1/z_far)
//                 pixels of what is behind get no dots
//   weak return   dark, shiny, glassy and grazing surfaces give too little light back, at the brink in
//   flickering blobs interference  where other projectors shine as well, windows fail in flickering blobs
//   always holes  outside 0.5 m to 5 m, and the rightmost 8 columns (of 640)
//
// Everything random is a hash of (seed, camera, frame, pixel).
// Source: Khoshelham and Elberink 2012 (levels, error of half a level); Barron and Malik 2013 (the constant,
// lateral error); Maimone and Fuchs 2011 (interference). Rates of change set beside recordings of a real one:
// docs/simulation.md.
//
// Thread: one thread per object.

#include <cstdint>
#include <vector>

#include "capture_server/simulation/true_camera.h"
#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::simulation {

inline constexpr double kProjectorBaseline = 0.075;               // metres
inline constexpr double kNearestDepth = 0.5, kFarthestDepth = 5;  // metres
inline constexpr double kLevelConstant = 351.3;                   // metres: z of level k is this over k

/// The depth values that a simulated Kinect can report, ascending, in `unit`.
std::vector<std::uint16_t> kinect_levels(DepthUnit unit);

/// Width in pixels of the shadow that something at z_near throws on something at z_far, metres.
constexpr double shadow_width_px(double fx, double z_near, double z_far) {
  return fx * kProjectorBaseline * (1 / z_near - 1 / z_far);
}

class KinectNoise {
 public:
  KinectNoise(const CameraModel& model, DepthUnit unit, std::uint32_t seed, std::uint32_t camera);

  /// Light of other projectors per pixel, as a multiple of the camera's own; 0 (the start) for none.
  /// Requires the model's size.
  void set_interference(const Image<float>& light);

  /// One exposure. Requires a view of the model's size.
  void expose(const TrueView& view, std::uint64_t frame, DepthImage& depth);

 private:
  void cast_shadow(const TrueView& view);

  CameraModel model_;
  DepthUnit unit_;
  std::uint32_t seed_;
  Image<float> pattern_;             // fixed error of the disparity, in levels
  Image<float> strength_needed_;     // fixed part of what a return must have
  Image<float> rivals_fixed_;        // where other projectors disturb in every frame
  Image<float> drowning_;            // how much of this frame's luck they need to drown a pixel
  Image<float> signal_, back_;       // what comes back, see cast_shadow()
  std::vector<float> exact_column_;  // per pixel of a row, its projector column
  std::vector<int> column_;          // rounded down
  std::vector<float> nearest_;       // per projector column, the nearest surface
};

}  // namespace copresence::simulation
