#pragma once

// The viewer: the viewpoint that --view selects, and the poses of the viewer's eyes. Thread: one
// thread at a time per object.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "render_client/viewpoint/eye.h"
#include "render_client/viewpoint/opentrack_view.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// A value of --view: mouse, path:FILE or opentrack[:PORT]. kFixed is the default without a window.
struct ViewChoice {
  enum class Kind { kFixed, kMouse, kPath, kOpentrack };
  Kind kind = Kind::kFixed;
  std::string path_file;
  std::uint16_t tracker_port = OpentrackView::kPort;
};

/// The size and field of view of the views.
struct ViewFormat {
  int width = 1280, height = 720;  ///< Pixels.
  /// The vertical field of view. The default is kFovDegrees. It is less if the view begins at a
  /// camera (kFixed and kMouse) whose picture would not fill the window.
  std::optional<double> fov_degrees;
};
inline constexpr double kFovDegrees = 50;

/// Parses a value of --view. Returns nothing if `text` is invalid.
std::optional<ViewChoice> parse_view(std::string_view text);

class Viewer {
 public:
  /// `up` is the world's upward direction. Fails if the path file is unreadable or invalid, or if
  /// the head tracker's port is in use.
  static Result<Viewer> open(const ViewChoice& choice, const ViewFormat& format, const Eigen::Vector3d& up);

  /// Sets a camera's pose and intrinsics. The reset pose is the pose of the first listed camera.
  /// Until that camera has a pose, it is the pose of the first listed camera that has a pose.
  void on_camera_pose(std::size_t index, const Rigid3& world_from_camera, const CameraModel& model);

  void apply(const Gesture& gesture) { viewpoint_->apply(gesture); }

  /// Returns a pose for each eye of the display. A display with one picture has the eye Eye{}. The
  /// other parameters are as in Viewpoint::at().
  std::vector<ViewPose> at(std::uint64_t view_index, Instant display_time, std::span<const Eye> eyes);

  std::optional<News> news(Instant now) { return viewpoint_->news(now); }

  /// Returns the datagram counters, or null if there is no head tracker.
  const OpentrackView::Counters* head_tracker() const { return tracker_ ? &tracker_->counters() : nullptr; }

 private:
  Viewer(std::unique_ptr<Viewpoint> viewpoint, const ViewFormat& format, bool fills_window)
      : viewpoint_(std::move(viewpoint)), format_(format), fills_window_(fills_window) {}

  std::unique_ptr<Viewpoint> viewpoint_;
  ViewFormat format_;
  bool fills_window_;                        // Whether the field of view follows that of a camera.
  const OpentrackView* tracker_ = nullptr;   // The viewpoint, if it is a head tracker.
  std::optional<std::size_t> reset_camera_;  // Index of the camera whose pose is the reset pose.
};

}  // namespace copresence::viewpoint
