#pragma once

// A Kinect in a simulated scene: depth with the errors of a Kinect and colour registered to it,
// frame by frame.
//
// Thread: one thread per camera; several cameras may share a scene.

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

/// The intrinsics of a Kinect at the given size: a focal length of 585 px at a width of 640 px, no
/// distortion. Requires a size that check() accepts.
CameraModel kinect_model(int width, int height);

/// Which Kinects have their projector on, by their index in kinect_poses().
using Projectors = std::bitset<kMostKinects>;

class SimulatedKinect {
 public:
  /// One of several Kinects that run at once, number `index` of `poses` (world_from_camera). The
  /// seed determines all noise.
  /// Fails  as TrueCamera::make(). Requires index < poses.size() <= kMostKinects.
  static Result<SimulatedKinect> make(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                                      std::span<const Rigid3> poses, std::size_t index, DepthUnit unit,
                                      std::uint32_t seed);

  /// Sets which projectors are on; initially all. The camera has no depth without its own. Those of
  /// others interfere.
  void set_projectors(Projectors on);

  /// Captures a frame with the figure at `phase`. The noise depends on the frame number only.
  void capture(double phase, std::uint64_t frame, DepthImage& depth, ColorImage& color);

  /// The ground truth of the last capture(). Requires that there was one.
  const TrueView& truth() const { return *truth_; }

  /// Traces one period of the figure's motion and caches it, which takes about 40 MB. After that, a
  /// live frame costs little more than its noise.
  void precompute();

  /// As capture(), but fast enough for a live camera, and one picture at a time. The phase is that
  /// of frame `frame` of an endless motion with the period kPeriodFrames. Pictures are row by row.
  /// Requires precompute() and the model's size.
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
  std::vector<Image<float>> projector_light_;  // of each projector, see light_of(); its own is empty
  Projectors on_;
  KinectNoise noise_;
  ColorResponse response_;
  NoiseFreeFrame captured_;  // of the last capture()
  const TrueView* truth_ = nullptr;
  std::unique_ptr<FrameCache> cache_;  // one period, after precompute()
};

}  // namespace copresence::simulation
