#include "simulation/simulated_kinect.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace copresence::simulation {
namespace {

// Light of another projector on what this camera sees, as a multiple of its own. The figure is left out: its
// pixels get what the room behind them does.
Image<float> light_of(const Rigid3& other, const World& world, const TrueView& view, const CameraModel& model,
                      const Rigid3& camera) {
  Image<float> light(model.width, model.height, 0.0f);
  const auto eye_rays = rays(model);
  const Rigid3 other_from_camera = other.inverse() * camera;
  const Eigen::Vector3f projector = other.translation.cast<float>();
  for (std::size_t i = 0; i < eye_rays.size(); ++i) {
    const double z = view.depth_m.data()[i];
    if (z <= 0) continue;
    const Eigen::Vector3d point(eye_rays[i].x() * z, eye_rays[i].y() * z, z);
    const Eigen::Vector3d there = other_from_camera * point;
    if (there.z() < 0.2) continue;
    const Eigen::Vector2d pixel = project(model, there);
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > model.width - 1 || pixel.y() > model.height - 1)
      continue;
    const Eigen::Vector3f in_world = (camera * point).cast<float>();
    if (world.still().is_blocked(projector, in_world - projector, 1e-3f, 0.99f)) continue;
    light.data()[i] = static_cast<float>(std::min(2.0, z * z / there.squaredNorm()));
  }
  return light;
}

}  // namespace

CameraModel kinect_model(int width, int height) {
  const double focal = 585.0 * width / 640;
  // The middle of the picture, half a pixel beside the nominal principal point (common/frame/camera_model.h).
  // As with a real Kinect, only calibration tells; recordings and scene files of simulated cameras say it.
  return {width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), {}};
}

Rigid3 look_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitY().cross(z).normalized();
  Rigid3 pose;
  pose.rotation << x, z.cross(x), z;
  pose.translation = eye;
  return pose;
}

std::vector<Rigid3> kinect_poses(int count) {
  assert(count >= 1 && count <= kMostKinects);
  static constexpr double kAround[] = {-35, 35, 142, -142,
                                       0,   90, -90, 180};  // degrees, from the figure's front
  static constexpr double kDistance[] = {2.35, 2.35, 2.2, 2.2, 2.25, 2.3, 2.3, 2.1};  // metres
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = kAround[i] * std::numbers::pi / 180;
    poses.push_back(
        look_from({kDistance[i] * std::sin(angle), -1.5, -kDistance[i] * std::cos(angle)}, {0, -0.95, 0}));
  }
  return poses;
}

Result<SimulatedKinect> SimulatedKinect::make(std::shared_ptr<const World> world, const CameraModel& model,
                                              std::span<const Rigid3> poses, std::size_t index,
                                              DepthUnit unit, std::uint32_t seed) {
  assert(index < poses.size() && poses.size() <= kMostKinects);
  auto camera = TrueCamera::make(world, model, poses[index]);
  if (!camera) return fail(camera.error());
  SimulatedKinect made(std::move(*camera), unit, seed, static_cast<std::uint32_t>(index));
  Projectors all;
  for (std::size_t other = 0; other < poses.size(); ++other) {
    all.set(other);
    made.rivals_.push_back(other == index
                               ? Image<float>()
                               : light_of(poses[other], *world, made.camera_.still(), model, poses[index]));
  }
  made.set_projectors(all);
  return made;
}

SimulatedKinect::SimulatedKinect(TrueCamera camera, DepthUnit unit, std::uint32_t seed, std::uint32_t index)
    : camera_(std::move(camera)),
      index_(index),
      noise_(camera_.model(), unit, seed, index),
      response_(camera_.model().width, camera_.model().height, seed, index) {}

void SimulatedKinect::set_projectors(Projectors on) {
  if (on == on_) return;
  on_ = on;
  Image<float> light(model().width, model().height, 0.0f);
  for (std::size_t other = 0; other < rivals_.size(); ++other) {
    if (other == index_ || !on[other]) continue;
    for (std::size_t i = 0; i < light.pixels().size(); ++i) light.data()[i] += rivals_[other].data()[i];
  }
  noise_.set_interference(light);
}

void SimulatedKinect::sense(const TrueView& truth, SensedView& sensed) const {
  project_dots(model(), truth, sensed.dots);
  response_.sense(truth.color, sensed.colors);
}

void SimulatedKinect::expose_dots(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth) {
  if (on_[index_]) {
    noise_.expose(dots, frame, depth);
  } else {
    std::ranges::fill(depth, std::uint16_t{0});
  }
}

void SimulatedKinect::expose(double phase, std::uint64_t frame, DepthImage& depth, ColorImage& color) {
  truth_ = &camera_.look(phase);
  sense(*truth_, sensed_);
  depth.resize(model().width, model().height);
  color.resize(model().width, model().height);
  expose_dots(sensed_.dots, frame, depth.pixels());
  response_.expose(sensed_.colors, frame, color.pixels());
}

void SimulatedKinect::foresee() {
  if (foreseen_) return;
  SensedView sensed;
  sense(camera_.still(), sensed);
  const std::size_t views = camera_.sees_motion() ? kPeriodFrames : 1;
  foreseen_ = std::make_unique<RememberedViews>(views, sensed);
  for (std::size_t i = 0; i < views; ++i) {
    sense(camera_.glance(phase_of_frame(i, kPeriodFrames)), sensed);
    foreseen_->remember(i, sensed);
  }
}

const SensedView& SimulatedKinect::live_view(std::uint64_t frame) {
  assert(foreseen_);
  return foreseen_->show(static_cast<std::size_t>(frame % foreseen_->count()));
}

void SimulatedKinect::expose_live_depth(std::uint64_t frame, std::span<std::uint16_t> depth) {
  expose_dots(live_view(frame).dots, frame, depth);
}

void SimulatedKinect::expose_live_color(std::uint64_t frame, std::span<Rgb8> color) {
  response_.expose(live_view(frame).colors, frame, color);
}

}  // namespace copresence::simulation
