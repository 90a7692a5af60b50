#pragma once

// The viewer: the viewpoint that --view names, and the poses of the viewer's eyes.
//
// Thread: one at a time.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "render_client/viewpoint/opentrack_view.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// A value of --view: mouse, path:FILE or opentrack[:PORT]; or kFixed, which has no name.
struct ViewChoice {
  enum class Kind { kFixed, kMouse, kPath, kOpentrack };
  Kind kind = Kind::kFixed;
  std::string path_file;                              ///< of kPath
  std::uint16_t tracker_port = OpentrackView::kPort;  ///< of kOpentrack
};

/// Size and field of view of the views.
struct ViewFormat {
  int width = 1280, height = 720;  ///< pixels
  /// Vertical. Without it, the field of view is kFovDegrees. A fixed view and one moved with the mouse
  /// begin at a camera. Their field of view is smaller where the camera's picture would not fill it.
  std::optional<double> fov_degrees;
};
inline constexpr double kFovDegrees = 50;

/// Nothing if `text` is not a value of --view.
std::optional<ViewChoice> parse_view(std::string_view text);

class Viewer {
 public:
  /// `up` is the world's.
  /// Fails if the path file is unreadable or invalid, or if the head tracker's port is in use.
  static Result<Viewer> open(const ViewChoice& choice, const ViewFormat& format, const Eigen::Vector3d& up);

  /// Tells the viewer a camera's pose and intrinsics. The reset pose is that of the first listed camera. Until
  /// that camera has come, it is the pose of the first listed camera among those that have.
  void on_camera_pose(std::size_t index, const Rigid3& world_from_camera, const CameraModel& model);

  void apply(const Gesture& gesture) { viewpoint_->apply(gesture); }

  /// A pose for each of `head_from_eyes`, the poses of a display's eyes in the viewer's head. A
  /// display with one picture has one eye, at the identity. Other parameters as in Viewpoint::at().
  std::vector<ViewPose> at(std::uint64_t view_index, Instant display_time,
                           std::span<const Rigid3> head_from_eyes);

  std::optional<News> news(Instant now) { return viewpoint_->news(now); }

  /// Datagrams of the head tracker; null unless --view names one.
  const OpentrackView::Counters* head_tracker() const { return tracker_ ? &tracker_->counters() : nullptr; }

 private:
  Viewer(std::unique_ptr<Viewpoint> viewpoint, const ViewFormat& format, bool fills_window)
      : viewpoint_(std::move(viewpoint)), format_(format), fills_window_(fills_window) {}

  std::unique_ptr<Viewpoint> viewpoint_;
  ViewFormat format_;
  bool fills_window_;                        // the field of view follows the camera at the reset pose
  const OpentrackView* tracker_ = nullptr;   // the viewpoint, if it is a head tracker
  std::optional<std::size_t> reset_camera_;  // index of the camera whose pose is the reset pose
};

}  // namespace copresence::viewpoint
