#include "render_client/viewpoint/viewer.h"

#include <algorithm>
#include <charconv>
#include <numbers>

#include "render_client/viewpoint/orbit_view.h"
#include "render_client/viewpoint/scripted_views.h"

namespace copresence::viewpoint {
namespace {

constexpr double kPivotM = 2.0;  // A typical distance of a person from a Kinect.

using Kind = ViewChoice::Kind;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// Returns a camera whose picture lies within that of `other` at the same pose. Its vertical field
/// of view is `vertical` radians or less. Lens distortion is ignored.
CameraModel camera_within(int width, int height, double vertical, const CameraModel& other) {
  CameraModel camera = camera_from_field_of_view(width, height, vertical);
  const auto is_inside = [](double center, int pixels) { return center > 0 && center < pixels - 1; };
  if (!is_inside(other.cx, other.width) || !is_inside(other.cy, other.height)) return camera;
  // Along each axis, the first and the last pixel must lie in the picture of `other`.
  const auto least_focal = [](double center, int pixels, double focal, double other_center,
                              int other_pixels) {
    return focal * std::max(center / other_center, (pixels - 1 - center) / (other_pixels - 1 - other_center));
  };
  camera.fx = camera.fy = std::max({camera.fy, least_focal(camera.cx, width, other.fx, other.cx, other.width),
                                    least_focal(camera.cy, height, other.fy, other.cy, other.height)});
  return camera;
}

/// Parses a port from 1 to 65535. Returns nothing for other texts.
std::optional<std::uint16_t> parse_port(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  const bool is_port = error == std::errc() && end == text.data() + text.size() && port > 0;
  return is_port ? std::optional(port) : std::nullopt;
}

}  // namespace

std::optional<ViewChoice> parse_view(std::string_view text) {
  constexpr std::string_view kPath = "path:", kTracker = "opentrack", kTrackerPort = "opentrack:";
  if (text == "mouse") return ViewChoice{Kind::kMouse, {}};
  if (text == kTracker) return ViewChoice{Kind::kOpentrack, {}};
  if (text.starts_with(kPath) && text.size() > kPath.size())
    return ViewChoice{Kind::kPath, std::string(text.substr(kPath.size()))};
  if (!text.starts_with(kTrackerPort)) return std::nullopt;
  const auto port = parse_port(text.substr(kTrackerPort.size()));
  return port ? std::optional(ViewChoice{Kind::kOpentrack, {}, *port}) : std::nullopt;
}

Result<Viewer> Viewer::open(const ViewChoice& choice, const ViewFormat& format, const Eigen::Vector3d& up) {
  const CameraModel intrinsics = camera_from_field_of_view(format.width, format.height,
                                                           radians(format.fov_degrees.value_or(kFovDegrees)));
  const bool fills_window = !format.fov_degrees;
  switch (choice.kind) {
    case Kind::kFixed:
      break;
    case Kind::kMouse:
      return Viewer(std::make_unique<OrbitView>(intrinsics, up, kPivotM), format, fills_window);
    case Kind::kPath: {
      auto path = EyePath::load(choice.path_file);
      if (!path) return fail(path.error());
      return Viewer(std::make_unique<PathView>(intrinsics, std::move(*path), up), format, false);
    }
    case Kind::kOpentrack: {
      auto opened = OpentrackView::open(intrinsics, choice.tracker_port);
      if (!opened) return fail(opened.error());
      auto tracker = std::make_unique<OpentrackView>(std::move(*opened));
      const OpentrackView* const counted = tracker.get();
      Viewer viewer(std::move(tracker), format, false);
      viewer.tracker_ = counted;
      return viewer;
    }
  }
  return Viewer(std::make_unique<FixedView>(intrinsics), format, fills_window);
}

void Viewer::on_camera_pose(std::size_t index, const Rigid3& world_from_camera, const CameraModel& model) {
  if (reset_camera_ && *reset_camera_ <= index) return;
  reset_camera_ = index;
  viewpoint_->set_reset_pose(world_from_camera);
  if (fills_window_)
    viewpoint_->set_intrinsics(camera_within(format_.width, format_.height, radians(kFovDegrees), model));
}

std::vector<ViewPose> Viewer::at(std::uint64_t view_index, Instant display_time, std::span<const Eye> eyes) {
  const ViewPose head = viewpoint_->at(view_index, display_time);
  std::vector<ViewPose> poses;
  for (const Eye& eye : eyes) poses.push_back(pose_of_eye(head, eye));
  return poses;
}

}  // namespace copresence::viewpoint
