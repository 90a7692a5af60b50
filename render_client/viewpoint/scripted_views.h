#pragma once

// Viewpoints without user input: a fixed eye, and an eye on a scripted path.

#include <Eigen/Core>
#include <utility>

#include "render_client/viewpoint/eye_path.h"
#include "render_client/viewpoint/look_at.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// An eye that never moves. It is the default without a window.
class FixedView final : public Viewpoint {
 public:
  explicit FixedView(const CameraModel& intrinsics, const Rigid3& world_from_eye = {})
      : Viewpoint(intrinsics), world_from_eye_(world_from_eye) {}

  ViewPose at(std::uint64_t, Instant) override { return pose_at(world_from_eye_); }
  void set_reset_pose(const Rigid3& world_from_eye) override { world_from_eye_ = world_from_eye; }

 private:
  Rigid3 world_from_eye_;
};

/// An eye on a scripted path, for `--view path:FILE` (eye_path.h).
class PathView final : public Viewpoint {
 public:
  /// `up` is the world's upward direction.
  PathView(const CameraModel& intrinsics, EyePath path, const Eigen::Vector3d& up)
      : Viewpoint(intrinsics), path_(std::move(path)), up_(up) {}

  ViewPose at(std::uint64_t view_index, Instant) override {
    const EyePath::Place place = path_.at(view_index);
    return pose_at(look_at(place.eye, place.look, up_));
  }
  void set_reset_pose(const Rigid3&) override {}  // The path defines all poses.

 private:
  EyePath path_;
  Eigen::Vector3d up_;
};

}  // namespace copresence::viewpoint
