#include "render_client/decoding/frame_conditioning.h"

#include <cassert>

namespace copresence::decoding {

Clipper::Clipper(const client::CameraSetup& setup, const scene::Box& box)
    : setup_(setup), box_(box), rays_(rays(setup.model)) {}

void Clipper::apply(RgbdFrame& frame) const {
  assert(frame.depth.width() == setup_.model.width && frame.depth.height() == setup_.model.height);
  const Rigid3& world_from_camera = setup_.pose(frame.metadata);
  const Eigen::Matrix3f rotation = world_from_camera.rotation.cast<float>();
  const Eigen::Vector3f translation = world_from_camera.translation.cast<float>();
  const Eigen::Vector3f min = box_.min.cast<float>(), max = box_.max.cast<float>();
  const auto metres = static_cast<float>(metres_per_unit(setup_.unit));
  const auto depth = frame.depth.pixels();
  const auto state = frame.state.pixels();
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) continue;
    const float z = static_cast<float>(depth[i]) * metres;
    const Eigen::Vector3f p = rotation * Eigen::Vector3f(rays_[i].x() * z, rays_[i].y() * z, z) + translation;
    if ((p.array() >= min.array()).all() && (p.array() <= max.array()).all()) continue;
    depth[i] = 0;
    state[i] = DepthState::kHole;
  }
}

void FrameConditioner::begin(const client::CameraSetup& setup, const std::optional<scene::Box>& clip) {
  unit_ = setup.unit;
  noise_ = setup.noise;
  clipper_.reset();
  if (clip) clipper_.emplace(setup, *clip);
}

void FrameConditioner::apply(RgbdFrame& frame) {
  silhouette_colors_.apply(frame, unit_, noise_);
  if (clipper_) clipper_->apply(frame);
  smoothing_.smooth(frame.depth, unit_, noise_);
}

}  // namespace copresence::decoding
