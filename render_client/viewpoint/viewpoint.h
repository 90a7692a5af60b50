#pragma once

// The interface of everything that moves the viewer's eye: a fixed pose, a scripted path, the
// mouse, a head tracker.
//
// Thread: one at a time.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "common/frame/rgbd_frame.h"
#include "render_client/viewpoint/view_pose.h"

namespace copresence::viewpoint {

// What a person does to move the view, whatever the input device. Distances are fractions of the
// picture's height.
struct Orbit {
  double right = 0, down = 0;
};
struct Pan {
  double right = 0, down = 0;
};
struct Zoom {
  double notches = 0;  ///< of a mouse wheel; positive moves closer
};
struct ResetPose {};
using Gesture = std::variant<Orbit, Pan, Zoom, ResetPose>;

/// A line for the log about the input device.
struct News {
  bool is_trouble = false;
  std::string text;
};

class Viewpoint {
 public:
  /// `intrinsics` of the views.
  explicit Viewpoint(const CameraModel& intrinsics) : intrinsics_(intrinsics) {}
  virtual ~Viewpoint() = default;

  /// Pose and projection of view `view_index`, counted from 0, which is displayed at
  /// `display_time`.
  virtual ViewPose at(std::uint64_t view_index, Instant display_time) = 0;

  /// Sets the pose of the unmoved eye, that is, the pose of the first camera once it is known.
  virtual void set_reset_pose(const Rigid3& world_from_eye) = 0;

  /// Intrinsics of the views from now on; the same size.
  void set_intrinsics(const CameraModel& intrinsics) { intrinsics_ = intrinsics; }

  /// Ignored unless the view is moved by hand.
  virtual void apply(const Gesture&) {}

  /// The next line for the log, if there is one. Never waits; call it a few times a second.
  virtual std::optional<News> news(Instant) { return std::nullopt; }

 protected:
  const CameraModel& intrinsics() const { return intrinsics_; }
  ViewPose pose_at(const Rigid3& world_from_eye) const { return {intrinsics_, world_from_eye}; }

 private:
  CameraModel intrinsics_;
};

}  // namespace copresence::viewpoint
