#include "render_client/viewpoint/viewer.h"

#include <charconv>

#include "render_client/viewpoint/orbit_view.h"
#include "render_client/viewpoint/scripted_views.h"

namespace copresence::viewpoint {
namespace {

constexpr double kPivotM = 2.0;  // a typical distance of a person from a Kinect

using Kind = ViewChoice::Kind;

/// From 1 to 65535; nothing for other texts.
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

Result<Viewer> Viewer::open(const ViewChoice& choice, const CameraModel& intrinsics,
                            const Eigen::Vector3d& up) {
  switch (choice.kind) {
    case Kind::kFixed:
      break;
    case Kind::kMouse:
      return Viewer(std::make_unique<OrbitView>(intrinsics, up, kPivotM));
    case Kind::kPath: {
      auto path = EyePath::load(choice.path_file);
      if (!path) return fail(path.error());
      return Viewer(std::make_unique<PathView>(intrinsics, std::move(*path), up));
    }
    case Kind::kOpentrack: {
      auto opened = OpentrackView::open(intrinsics, choice.tracker_port);
      if (!opened) return fail(opened.error());
      auto tracker = std::make_unique<OpentrackView>(std::move(*opened));
      const OpentrackView* const counted = tracker.get();
      Viewer viewer(std::move(tracker));
      viewer.tracker_ = counted;
      return viewer;
    }
  }
  return Viewer(std::make_unique<FixedView>(intrinsics));
}

void Viewer::on_camera_pose(std::size_t index, const Rigid3& world_from_camera) {
  if (reset_camera_ && *reset_camera_ <= index) return;
  reset_camera_ = index;
  viewpoint_->set_reset_pose(world_from_camera);
}

std::vector<ViewPose> Viewer::at(std::uint64_t view_index, Instant display_time,
                                 std::span<const Rigid3> head_from_eyes) {
  const ViewPose head = viewpoint_->at(view_index, display_time);
  std::vector<ViewPose> eyes(head_from_eyes.size(), head);
  for (std::size_t i = 0; i < eyes.size(); ++i)
    eyes[i].world_from_eye = head.world_from_eye * head_from_eyes[i];
  return eyes;
}

}  // namespace copresence::viewpoint
