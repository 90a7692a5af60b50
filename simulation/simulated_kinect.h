#pragma once

// A Kinect in a simulated world: depth with a Kinect's faults and colour registered to it, frame by frame.
// Thread: one thread per camera; several cameras may share a world.

#include <bitset>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/color_response.h"
#include "simulation/kinect_noise.h"
#include "simulation/remembered_views.h"
#include "simulation/sensed_view.h"
#include "simulation/true_camera.h"
#include "simulation/world.h"

namespace copresence::simulation {

/// A Kinect's camera at the given size: 585 px focal length at 640 pixels of width, no distortion.
/// Requires a size that check() accepts.
CameraModel kinect_model(int width, int height);

/// Where `count` Kinects stand in a world of this project: around the figure, looking at it. The first two
/// are 70 degrees apart in front of it, the third and fourth behind. world_from_camera, metres. Requires 1 <=
/// count <= kMostKinects.
std::vector<Rigid3> kinect_poses(int count);
inline constexpr int kMostKinects = 8;

/// Which of the Kinects in a room have their projector on, by their place in kinect_poses().
using Projectors = std::bitset<kMostKinects>;

/// A pose that looks from `eye` to `target`, the picture upright (the world's y is down). Requires that the
/// two do not stand above each other.
Rigid3 look_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

class SimulatedKinect {
 public:
  /// One of several Kinects that run at once: `poses` are all of them, `index` says which one this is.
  /// Fails  as TrueCamera::make(). Requires index < poses.size() <= kMostKinects.
  static Result<SimulatedKinect> make(std::shared_ptr<const World> world, const CameraModel& model,
                                      std::span<const Rigid3> poses, std::size_t index, DepthUnit unit,
                                      std::uint32_t seed);

  /// Which projectors shine from now on: all, until it is told otherwise. Without its own it has no depth; those of
  /// the others disturb it.
  void set_projectors(Projectors on);

  /// What it delivers as its frame number `frame` when the world is at `phase`. The noise belongs to the
  /// frame number.
  void expose(double phase, std::uint64_t frame, DepthImage& depth, ColorImage& color);

  /// The truth behind the last expose(). Requires that there was one.
  const TrueView& truth() const { return *truth_; }

  /// Looks at one period of the figure's motion ahead, by triangles (TrueCamera::glance()), and remembers it: about 40 MB.
  /// From then on a live frame costs little more than its noise.
  void foresee();

  /// The same as expose() at the pace of a live camera, each picture by itself: the world is at the phase of frame `frame` of an
  /// endless motion of kPeriodFrames. Pictures are row by row. Requires foresee() and the model's size.
  void expose_live_depth(std::uint64_t frame, std::span<std::uint16_t> depth);
  void expose_live_color(std::uint64_t frame, std::span<Rgb8> color);

  const CameraModel& model() const { return camera_.model(); }
  const Rigid3& world_from_camera() const { return camera_.world_from_camera(); }

 private:
  SimulatedKinect(TrueCamera camera, DepthUnit unit, std::uint32_t seed, std::uint32_t index);
  void sense(const TrueView& truth, SensedView& sensed) const;
  const SensedView& live_view(std::uint64_t frame);
  void expose_dots(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth);

  TrueCamera camera_;
  std::size_t index_;
  std::vector<Image<float>> rivals_;  // light of each other projector, see light_of(); its own is empty
  Projectors on_;
  KinectNoise noise_;
  ColorResponse response_;
  SensedView sensed_;  // by the last expose()
  const TrueView* truth_ = nullptr;
  std::unique_ptr<RememberedViews> foreseen_;  // one period, once foresee() was called
};

}  // namespace copresence::simulation
