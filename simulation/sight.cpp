#include "simulation/sight.h"

namespace copresence::simulation {

Sight::Sight(const CameraModel& camera, const Rigid3& pose)
    : model(camera), world_from_camera(pose), eye(pose.translation.cast<float>()) {
  const Eigen::Matrix3f turn = pose.rotation.cast<float>();
  for (const Eigen::Vector2f& ray : rays(model))
    directions.push_back(turn * Eigen::Vector3f(ray.x(), ray.y(), 1));
  pixel_x = turn.col(0) / static_cast<float>(model.fx);
  pixel_y = turn.col(1) / static_cast<float>(model.fy);
}

}  // namespace copresence::simulation
