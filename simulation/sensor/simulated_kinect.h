#pragma once

// A Kinect in a simulated scene: depth with the errors of a Kinect, and colour registered to it.
// Thread: one thread at a time per camera; several cameras may share a scene.

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/sensor/color_response.h"
#include "simulation/sensor/frame_cache.h"
#include "simulation/sensor/kinect_depth.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulation {

/// The intrinsics of a Kinect at the given size: a focal length of 585 px at a width of 640 px, and
/// no distortion. Requires a size that check() accepts.
CameraModel kinect_model(int width, int height);

/// The Kinects whose projectors are on, by their index in kinect_poses().
using Projectors = std::bitset<kMostKinects>;

class SimulatedKinect {
 public:
  /// Creates Kinect number `index` of several that run at once, with the poses world_from_camera in
  /// `poses`. The seed determines all noise. Requires index < poses.size() <= kMostKinects.
  /// Fails as TrueCamera::make() does.
  static Result<SimulatedKinect> make(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                                      std::span<const Rigid3> poses, std::size_t index, DepthUnit unit,
                                      std::uint32_t seed);

  /// Sets which projectors are on. At first, all projectors are on. The camera has no depth while
  /// its own projector is off. Other projectors interfere.
  void set_projectors(Projectors on);

  /// Captures a frame with the figure at `phase`. The noise depends only on the frame number.
  void capture(double phase, std::uint64_t frame, DepthImage& depth, ColorImage& color);

  /// Returns the ground truth of the last capture(). Requires an earlier capture().
  const TrueView& truth() const { return *truth_; }

  /// Traces one period of the figure's motion and caches it, which takes about 40 MB. A live frame
  /// then takes little more time than its noise.
  void precompute();

  /// Captures one picture of frame `frame`, fast enough for a live camera. The phase is that of an
  /// endless motion with the period kPeriodFrames. Pictures are stored row by row. Requires an
  /// earlier precompute() and the model's size.
  void capture_live_depth(std::uint64_t frame, std::span<std::uint16_t> depth);
  void capture_live_color(std::uint64_t frame, std::span<Rgb8> color);

  const CameraModel& model() const { return camera_.model(); }
  const Rigid3& world_from_camera() const { return camera_.world_from_camera(); }

 private:
  SimulatedKinect(TrueCamera camera, DepthUnit unit, std::uint32_t seed, std::uint32_t index);
  void apply_response(const TrueView& truth, NoiseFreeFrame& frame) const;
  const NoiseFreeFrame& cached_frame(std::uint64_t frame);
  void add_depth_noise(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth);

  TrueCamera camera_;
  std::size_t index_;
  std::vector<Image<float>> projector_light_;  // Per projector, see light_of(). Its own is empty.
  Projectors on_;
  KinectNoise noise_;
  ColorResponse response_;
  NoiseFreeFrame captured_;  // The frame of the last capture().
  const TrueView* truth_ = nullptr;
  std::unique_ptr<FrameCache> cache_;  // The pointer is null before precompute(), then holds one period.
};

}  // namespace copresence::simulation
