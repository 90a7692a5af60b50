#pragma once

// Converts true depth to a Kinect v1's: disparity levels, correlated errors, ragged edges, holes.
//
// A Kinect projects a pattern of infrared dots and measures their disparity. project_dots()
// computes the exact disparity and intensity of the pattern per pixel. KinectNoise adds errors.
//
// - Levels: z = kLevelConstant / k for whole k. There are 632 levels from 0.5 m to 5 m.
// - Errors of the disparity before rounding: a fixed pattern per camera, and a part that changes
//   with
//   each frame. Both are correlated over several pixels, because the sensor correlates windows.
//   With the rounding, their standard deviation is half a level.
// - Edges: depth is taken from up to two pixels away, differently in each frame.
// - Weak return: dark, shiny, transparent and grazing surfaces reflect too little light. Blobs of
//   pixels near the threshold flicker.
// - Interference: where other projectors shine, depth is lost in flickering blobs.
// - Holes: depth outside 0.5 m to 5 m, and the rightmost 8 of 640 columns.
//
// All random values are hashes of (seed, camera, frame, pixel).
// Sources: Khoshelham and Elberink 2012 (levels, error of half a level); Barron and Malik 2013 (the
// constant, lateral error); Maimone and Fuchs 2011 (interference). docs/internals/simulation.md
// compares the rates of change with recordings of a real Kinect.
//
// Thread: free functions are safe anywhere; one thread at a time per KinectNoise.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulation {

// Distance of the projector from the camera in metres, to the right.
inline constexpr double kProjectorBaseline = 0.075;
/// In metres. Disparity level k has the depth kLevelConstant / k.
inline constexpr double kLevelConstant = kKinectV1Noise.disparity_constant_m;
inline constexpr double kNearestDepth = 0.5, kFarthestDepth = 5;  // In metres.

/// The depth values that a simulated Kinect can report, ascending, in `unit`.
std::vector<std::uint16_t> kinect_levels(DepthUnit unit);

/// Width in pixels of the shadow that a surface at depth z_near casts in the dots on a surface at
/// depth z_far. Both depths are in metres.
constexpr double shadow_width_px(double fx, double z_near, double z_far) {
  return fx * kProjectorBaseline * (1 / z_near - 1 / z_far);
}

/// The projected dots at one pixel.
struct Dots {
  float level = 0;      ///< Exact disparity in levels; 0 in the shadow of the projector.
  float intensity = 0;  ///< Reflected light. Automatic gain mostly makes up for the distance.
  friend bool operator==(const Dots&, const Dots&) = default;
};
using DotImage = Image<Dots>;

/// Computes the dots that the camera sees, without noise. A near surface has a shadow of
/// shadow_width_px() on its left. Requires a view of the model's size.
void project_dots(const CameraModel& model, const TrueView& view, DotImage& dots);

/// Turns dots into the depth of one Kinect.
class KinectNoise {
 public:
  KinectNoise(const CameraModel& model, DepthUnit unit, std::uint32_t seed, std::uint32_t camera);

  /// Sets the light of other projectors per pixel, as a multiple of the light of this camera's
  /// projector. That light is 0 at first. Requires the model's size.
  void set_interference(const Image<float>& light);

  /// Writes the depth of one frame row by row, in the given unit, with 0 for holes. Requires `dots`
  /// and `depth` of the model's size.
  void add_noise(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth);

 private:
  DepthUnit unit_;
  std::uint32_t seed_;
  Image<float> pattern_;  // The part of the disparity error that is the same in all frames, in levels.
  Image<float> needed_intensity_;  // The part of the threshold for intensity that is the same in all frames.
  Image<float> fixed_interference_;  // The part of the random interference that is the same in all frames.
  Image<float> interference_threshold_;  // Depth is lost where a frame's interference exceeds it.
};

}  // namespace copresence::simulation
