#include "render_client/viewpoint/look_at.h"

namespace copresence::viewpoint {
namespace {

constexpr double kNothing = 1e-9;  // In metres, or as the sine of an angle.

/// Returns a unit vector perpendicular to the unit vector `direction`.
Eigen::Vector3d across(const Eigen::Vector3d& direction) {
  Eigen::Index least = 0;
  direction.cwiseAbs().minCoeff(&least);
  return direction.cross(Eigen::Vector3d::Unit(least)).normalized();
}

}  // namespace

Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d towards = target - eye;
  const bool has_up = up.norm() > kNothing;
  Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();
  if (towards.norm() > kNothing) {
    forward = towards.normalized();
  } else if (has_up) {
    forward = across(up.normalized());
  }
  Eigen::Vector3d right = has_up ? Eigen::Vector3d(forward.cross(up.normalized())) : Eigen::Vector3d::Zero();
  right = right.norm() > kNothing ? right.normalized() : across(forward);
  Rigid3 world_from_eye;
  world_from_eye.rotation << right, forward.cross(right), forward;
  world_from_eye.translation = eye;
  return world_from_eye;
}

}  // namespace copresence::viewpoint
