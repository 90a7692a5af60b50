#pragma once

// What a Kinect v1 makes of the dots that come back to it (projected_dots.h): levels of an eighth of a pixel of disparity,
// correlated errors, ragged edges, and holes.
//
//   levels        a Kinect reports only z = kLevelConstant / k for whole k; 632 of them lie between 0.5 m and 5 m
//   errors        of the disparity before rounding: a fixed pattern per camera and a part that changes with each frame, both
//                 alike over several pixels, since the sensor correlates windows; together half a level
//   edges         depth is taken from up to two pixels beside, differently in each frame
//   weak return   dark, shiny, glassy and grazing surfaces give too little light back, at the brink in flickering blobs
//   interference  where other projectors shine as well, windows fail in flickering blobs
//   always holes  outside 0.5 m to 5 m, and the rightmost 8 columns (of 640)
//
// Everything random is a hash of (seed, camera, frame, pixel).
// Source: Khoshelham and Elberink 2012 (levels, error of half a level); Barron and Malik 2013 (the constant,
// lateral error); Maimone and Fuchs 2011 (interference). EncoderSettings of change set beside recordings of a real one:
// docs/internals/simulation.md.
//
// Thread: one thread per object.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "simulation/projected_dots.h"

namespace copresence::simulation {

inline constexpr double kNearestDepth = 0.5, kFarthestDepth = 5;  // metres

/// The depth values that a simulated Kinect can report, ascending, in `unit`.
std::vector<std::uint16_t> kinect_levels(DepthUnit unit);

class KinectNoise {
 public:
  KinectNoise(const CameraModel& model, DepthUnit unit, std::uint32_t seed, std::uint32_t camera);

  /// Light of other projectors per pixel, as a multiple of the camera's own; 0 (the start) for none.
  /// Requires the model's size.
  void set_interference(const Image<float>& light);

  /// One exposure: `depth` in the unit given, 0 for holes, row by row. Requires the model's size of both.
  void expose(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth);

 private:
  DepthUnit unit_;
  std::uint32_t seed_;
  Image<float> pattern_;          // fixed error of the disparity, in levels
  Image<float> strength_needed_;  // fixed part of what a return must have
  Image<float> rivals_fixed_;     // where other projectors disturb in every frame
  Image<float> drowning_;         // how much of this frame's luck they need to drown a pixel
};

}  // namespace copresence::simulation
