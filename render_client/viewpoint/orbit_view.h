#pragma once

// An eye that is moved by hand: around a pivot, sideways, closer or farther.
//
// Distances in gestures are fractions of the picture's height, so that the scene follows the
// pointer at any window size.

#include <Eigen/Core>

#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class OrbitView final : public Viewpoint {
 public:
  /// `up` is the world's upward direction. In the reset pose, the pivot lies `pivot_m` in front of
  /// the eye. Requires an `up` that is not zero and pivot_m > 0.
  OrbitView(const CameraModel& intrinsics, const Eigen::Vector3d& up, double pivot_m);

  /// Moves the eye to the new pose, unless a gesture has moved it away from the old pose. The first
  /// call always moves the eye, since nothing was visible before.
  void set_reset_pose(const Rigid3& world_from_eye) override;

  /// Orbit turns the scene with the pointer, by 180 degrees over the picture's height. The eye
  /// never passes over the top. Pan moves the scene with the pointer. A notch of zoom moves the eye
  /// a tenth of the way to the pivot. ResetPose returns to the last reset pose.
  void apply(const Gesture& gesture) override;

  ViewPose at(std::uint64_t, Instant) override { return pose_at(world_from_eye_); }

 private:
  void orbit(const Orbit& by);
  void pan(const Pan& by);
  void zoom(const Zoom& by);
  void reset();
  Eigen::Vector3d pivot() const { return world_from_eye_ * Eigen::Vector3d(0, 0, distance_m_); }
  void turn_about_pivot(const Eigen::Vector3d& axis, double angle);

  Eigen::Vector3d up_;
  double pivot_m_;
  bool has_reset_pose_ = false;
  Rigid3 reset_pose_;
  Rigid3 world_from_eye_;
  double distance_m_;  // The distance from the eye to the pivot.
};

}  // namespace copresence::viewpoint
