#include "render_client/clipping.h"

#include <cassert>

namespace copresence::client {

void clip(RgbdFrame& frame, const CameraModel& camera, DepthUnit unit, const Rigid3& world_from_camera,
          const scene::Box& box) {
  assert(frame.depth.width() == camera.width && frame.depth.height() == camera.height);
  const auto all_rays = rays(camera);
  const Eigen::Matrix3f rotation = world_from_camera.rotation.cast<float>();
  const Eigen::Vector3f translation = world_from_camera.translation.cast<float>();
  const Eigen::Vector3f min = box.min.cast<float>(), max = box.max.cast<float>();
  const auto metres = static_cast<float>(metres_per_unit(unit));
  const auto depth = frame.depth.pixels();
  const auto state = frame.state.pixels();
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) continue;
    const float z = static_cast<float>(depth[i]) * metres;
    const Eigen::Vector3f p =
        rotation * Eigen::Vector3f(all_rays[i].x() * z, all_rays[i].y() * z, z) + translation;
    if ((p.array() >= min.array()).all() && (p.array() <= max.array()).all()) continue;
    depth[i] = 0;
    state[i] = DepthState::kHole;
  }
}

}  // namespace copresence::client
