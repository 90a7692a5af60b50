#pragma once

// The interface of everything that moves the viewer's eye: a fixed pose, a scripted path, the mouse
// or a head tracker. Thread: one thread at a time per object.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "common/frame/rgbd_frame.h"
#include "render_client/viewpoint/view_pose.h"

namespace copresence::viewpoint {

// The gestures by which the user moves the view. Distances are fractions of the picture's height.
struct Orbit {
  double right = 0, down = 0;
};
struct Pan {
  double right = 0, down = 0;
};
struct Zoom {
  double notches = 0;  ///< Notches of a mouse wheel. Positive numbers move the eye closer.
};
struct ResetPose {};
using Gesture = std::variant<Orbit, Pan, Zoom, ResetPose>;

/// A log line about the input device.
struct News {
  bool is_trouble = false;
  std::string text;
};

class Viewpoint {
 public:
  explicit Viewpoint(const CameraModel& intrinsics) : intrinsics_(intrinsics) {}
  virtual ~Viewpoint() = default;

  /// Returns the pose and projection of view `view_index` (from 0), displayed at `display_time`.
  virtual ViewPose at(std::uint64_t view_index, Instant display_time) = 0;

  /// Sets the pose of the eye before any motion: the pose of the first camera, once it is known.
  virtual void set_reset_pose(const Rigid3& world_from_eye) = 0;

  /// Sets the intrinsics of later views. Requires the same picture size.
  void set_intrinsics(const CameraModel& intrinsics) { intrinsics_ = intrinsics; }

  /// Moves the eye. It has no effect unless the view is moved by hand.
  virtual void apply(const Gesture&) {}

  /// Returns the next log line, if there is one. Never waits. Call it a few times a second.
  virtual std::optional<News> news(Instant) { return std::nullopt; }

 protected:
  const CameraModel& intrinsics() const { return intrinsics_; }
  ViewPose pose_at(const Rigid3& world_from_eye) const { return {intrinsics_, world_from_eye}; }

 private:
  CameraModel intrinsics_;
};

}  // namespace copresence::viewpoint
