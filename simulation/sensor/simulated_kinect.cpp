#include "simulation/sensor/simulated_kinect.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "simulation/truth/ray_tracer.h"

namespace copresence::simulation {
namespace {

// Returns the light of another projector at each pixel, as a multiple of the light of this camera's
// projector. The figure is ignored: its pixels get the light of the background.
Image<float> light_of(const Rigid3& other, const LitScene& scene, const TrueView& view,
                      const CameraModel& model, const Rigid3& camera) {
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
    if (scene.background().is_blocked(projector, in_world - projector, 1e-3f, 0.99f)) continue;
    light.data()[i] = static_cast<float>(std::min(2.0, z * z / there.squaredNorm()));
  }
  return light;
}

}  // namespace

CameraModel kinect_model(int width, int height) {
  const double focal = 585.0 * width / 640;
  // The principal point is the centre of the picture, half a pixel from the nominal one
  // (camera_model.h). Recordings and scene files of simulated cameras state the principal point,
  // and calibration finds it, as with a real Kinect.
  return {width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), {}};
}

Result<SimulatedKinect> SimulatedKinect::make(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                                              std::span<const Rigid3> poses, std::size_t index,
                                              DepthUnit unit, std::uint32_t seed) {
  assert(index < poses.size() && poses.size() <= kMostKinects);
  auto camera = TrueCamera::make(scene, model, poses[index]);
  if (!camera) return fail(camera.error());
  SimulatedKinect made(std::move(*camera), unit, seed, static_cast<std::uint32_t>(index));
  Projectors all;
  for (std::size_t other = 0; other < poses.size(); ++other) {
    all.set(other);
    made.projector_light_.push_back(
        other == index ? Image<float>()
                       : light_of(poses[other], *scene, made.camera_.background(), model, poses[index]));
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
  for (std::size_t other = 0; other < projector_light_.size(); ++other) {
    if (other == index_ || !on[other]) continue;
    for (std::size_t i = 0; i < light.pixels().size(); ++i)
      light.data()[i] += projector_light_[other].data()[i];
  }
  noise_.set_interference(light);
}

void SimulatedKinect::apply_response(const TrueView& truth, NoiseFreeFrame& frame) const {
  project_dots(model(), truth, frame.dots);
  response_.apply_response(truth.color, frame.colors);
}

void SimulatedKinect::add_depth_noise(const DotImage& dots, std::uint64_t frame,
                                      std::span<std::uint16_t> depth) {
  if (on_[index_]) {
    noise_.add_noise(dots, frame, depth);
  } else {
    std::ranges::fill(depth, std::uint16_t{0});
  }
}

void SimulatedKinect::capture(double phase, std::uint64_t frame, DepthImage& depth, ColorImage& color) {
  truth_ = &camera_.trace(phase);
  apply_response(*truth_, captured_);
  depth.resize(model().width, model().height);
  color.resize(model().width, model().height);
  add_depth_noise(captured_.dots, frame, depth.pixels());
  response_.add_noise(captured_.colors, frame, color.pixels());
}

void SimulatedKinect::precompute() {
  if (cache_) return;
  NoiseFreeFrame frame;
  apply_response(camera_.background(), frame);
  const std::size_t count = camera_.sees_motion() ? kPeriodFrames : 1;
  cache_ = std::make_unique<FrameCache>(count, frame);
  for (std::size_t i = 0; i < count; ++i) {
    apply_response(camera_.trace(phase_of_frame(i, kPeriodFrames)), frame);
    cache_->store(i, frame);
  }
}

const NoiseFreeFrame& SimulatedKinect::cached_frame(std::uint64_t frame) {
  assert(cache_);
  return cache_->load(static_cast<std::size_t>(frame % cache_->count()));
}

void SimulatedKinect::capture_live_depth(std::uint64_t frame, std::span<std::uint16_t> depth) {
  add_depth_noise(cached_frame(frame).dots, frame, depth);
}

void SimulatedKinect::capture_live_color(std::uint64_t frame, std::span<Rgb8> color) {
  response_.add_noise(cached_frame(frame).colors, frame, color);
}

}  // namespace copresence::simulation
