#include "render_client/viewpoint/orbit_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace copresence::viewpoint {
namespace {

constexpr double kTurnPerHeight = std::numbers::pi;
constexpr double kClosestToPole = 2.0 * std::numbers::pi / 180;  // to straight up and down
constexpr double kZoomPerNotch = 0.9;
constexpr double kNearest = 0.1, kFarthest = 30;  // metres between eye and pivot

}  // namespace

OrbitView::OrbitView(const Eigen::Vector3d& up, double pivot_m, double fov_degrees)
    : up_(up.normalized()),
      pivot_m_(pivot_m),
      metres_per_height_(2 * std::tan(fov_degrees * std::numbers::pi / 360)),
      distance_m_(pivot_m) {
  assert(up.norm() > 0 && pivot_m > 0 && fov_degrees > 0 && fov_degrees < 180);
}

void OrbitView::set_home(const Rigid3& world_from_home) {
  const bool is_moved = has_home_ && (!(world_from_eye_ == world_from_home_) || distance_m_ != pivot_m_);
  has_home_ = true;
  world_from_home_ = world_from_home;
  if (!is_moved) go_home();
}

void OrbitView::go_home() {
  world_from_eye_ = world_from_home_;
  distance_m_ = pivot_m_;
}

void OrbitView::turn_about_pivot(const Eigen::Vector3d& axis, double angle) {
  const Eigen::Vector3d fixed = pivot();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  // Through a quaternion, so that a day of mouse moves adds up to a rotation still.
  world_from_eye_.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(turn * world_from_eye_.rotation)).normalized().toRotationMatrix();
  world_from_eye_.translation = fixed - world_from_eye_.rotation.col(2) * distance_m_;
}

void OrbitView::orbit(double right, double down) {
  turn_about_pivot(up_, -right * kTurnPerHeight);
  // The angle between forward and up shrinks when the pointer goes up: the scene's front turns up, the eye
  // sinks.
  const double from_up = std::acos(std::clamp(world_from_eye_.rotation.col(2).dot(up_), -1.0, 1.0));
  const double lowest = std::min(kClosestToPole, from_up);
  const double highest = std::max(std::numbers::pi - kClosestToPole, from_up);
  const double wanted = std::clamp(from_up + down * kTurnPerHeight, lowest, highest);
  turn_about_pivot(world_from_eye_.rotation.col(0), from_up - wanted);
}

void OrbitView::pan(double right, double down) {
  const double metres = metres_per_height_ * distance_m_;
  world_from_eye_.translation -= world_from_eye_.rotation * Eigen::Vector3d(right * metres, down * metres, 0);
}

void OrbitView::zoom(double notches) {
  const Eigen::Vector3d fixed = pivot();
  distance_m_ = std::clamp(distance_m_ * std::pow(kZoomPerNotch, notches), kNearest, kFarthest);
  world_from_eye_.translation = fixed - world_from_eye_.rotation.col(2) * distance_m_;
}

}  // namespace copresence::viewpoint
