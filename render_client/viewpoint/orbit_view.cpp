#include "render_client/viewpoint/orbit_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace copresence::viewpoint {
namespace {

constexpr double kTurnPerHeight = std::numbers::pi;
// Minimum angle between the view's direction and the vertical.
constexpr double kClosestToPole = 2.0 * std::numbers::pi / 180;
constexpr double kZoomPerNotch = 0.9;
constexpr double kNearest = 0.1, kFarthest = 30;  // Metres between eye and pivot.

}  // namespace

OrbitView::OrbitView(const CameraModel& intrinsics, const Eigen::Vector3d& up, double pivot_m)
    : Viewpoint(intrinsics), up_(up.normalized()), pivot_m_(pivot_m), distance_m_(pivot_m) {
  assert(up.norm() > 0 && pivot_m > 0 && intrinsics.fy > 0);
}

void OrbitView::set_reset_pose(const Rigid3& world_from_eye) {
  const bool is_moved = has_reset_pose_ && (!(world_from_eye_ == reset_pose_) || distance_m_ != pivot_m_);
  has_reset_pose_ = true;
  reset_pose_ = world_from_eye;
  if (!is_moved) reset();
}

void OrbitView::apply(const Gesture& gesture) {
  if (const auto* orbit_by = std::get_if<Orbit>(&gesture)) {
    orbit(*orbit_by);
  } else if (const auto* pan_by = std::get_if<Pan>(&gesture)) {
    pan(*pan_by);
  } else if (const auto* zoom_by = std::get_if<Zoom>(&gesture)) {
    zoom(*zoom_by);
  } else {
    reset();
  }
}

void OrbitView::reset() {
  world_from_eye_ = reset_pose_;
  distance_m_ = pivot_m_;
}

void OrbitView::turn_about_pivot(const Eigen::Vector3d& axis, double angle) {
  const Eigen::Vector3d fixed = pivot();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  // The rotation is normalised, because the rounding errors of many mouse moves would accumulate.
  world_from_eye_.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(turn * world_from_eye_.rotation)).normalized().toRotationMatrix();
  world_from_eye_.translation = fixed - world_from_eye_.rotation.col(2) * distance_m_;
}

void OrbitView::orbit(const Orbit& by) {
  turn_about_pivot(up_, -by.right * kTurnPerHeight);
  // When the pointer moves up, the front of the scene turns up: the eye sinks and looks upward.
  const double from_up = std::acos(std::clamp(world_from_eye_.rotation.col(2).dot(up_), -1.0, 1.0));
  const double lowest = std::min(kClosestToPole, from_up);
  const double highest = std::max(std::numbers::pi - kClosestToPole, from_up);
  const double wanted = std::clamp(from_up + by.down * kTurnPerHeight, lowest, highest);
  turn_about_pivot(world_from_eye_.rotation.col(0), from_up - wanted);
}

void OrbitView::pan(const Pan& by) {
  const double height_at_one_metre = intrinsics().height / intrinsics().fy;
  const double metres = height_at_one_metre * distance_m_;
  world_from_eye_.translation -=
      world_from_eye_.rotation * Eigen::Vector3d(by.right * metres, by.down * metres, 0);
}

void OrbitView::zoom(const Zoom& by) {
  const Eigen::Vector3d fixed = pivot();
  distance_m_ = std::clamp(distance_m_ * std::pow(kZoomPerNotch, by.notches), kNearest, kFarthest);
  world_from_eye_.translation = fixed - world_from_eye_.rotation.col(2) * distance_m_;
}

}  // namespace copresence::viewpoint
