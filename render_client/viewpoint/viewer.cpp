#include "render_client/viewpoint/viewer.h"

#include <spdlog/spdlog.h>

#include "render_client/viewpoint/fixed_view.h"
#include "render_client/viewpoint/path_view.h"

namespace copresence::client {
namespace {

constexpr double kPivotM = 2.0;  // about where a person stands before a Kinect
constexpr std::string_view kPath = "path:";

}  // namespace

Result<Eye> Eye::open(const ClientSettings& settings, const scene::Scene* scene) {
  const CameraModel lens = renderer::lens_from_fov(settings.width, settings.height, settings.fov_degrees);
  const Eigen::Vector3d up = scene ? scene->up : scene::Scene{}.up;
  if (settings.view == "mouse" || (settings.view.empty() && !settings.headless)) {
    return Eye(lens, std::make_unique<viewpoint::OrbitView>(up, kPivotM, settings.fov_degrees));
  }
  if (settings.view.empty()) return Eye(lens, std::make_unique<viewpoint::FixedView>());
  if (settings.view.starts_with(kPath)) {
    auto path = viewpoint::EyePath::load(settings.view.substr(kPath.size()));
    if (!path) return fail(path.error());
    return Eye(lens, std::make_unique<viewpoint::PathView>(std::move(*path), up));
  }
  auto tracker = viewpoint::OpentrackView::open(*opentrack_port(settings.view));
  if (!tracker) return fail(tracker.error());
  return Eye(lens, std::make_unique<viewpoint::OpentrackView>(std::move(*tracker)));
}

void Eye::see_camera(std::size_t index, const Rigid3& world_from_camera) {
  if (home_ && *home_ <= index) return;
  home_ = index;
  viewpoint_->set_home(world_from_camera);
}

void Eye::handle(const std::vector<window::Event>& events, int picture_height) {
  for (const window::Event& event : events) {
    if (const auto* move = std::get_if<window::MoveEvent>(&event)) {
      drag(*move, picture_height);
    } else if (const auto* scroll = std::get_if<window::ScrollEvent>(&event); scroll && orbit_) {
      orbit_->zoom(scroll->y);
    } else if (const auto* key = std::get_if<window::KeyEvent>(&event); key && key->pressed && orbit_) {
      if (key->key == window::Key{'R'} || key->key == window::Key::kHome) orbit_->go_home();
    }
  }
}

void Eye::drag(const window::MoveEvent& move, int picture_height) {
  if (orbit_ && last_move_ && picture_height > 0) {
    const double right = (move.x - last_move_->x) / picture_height;
    const double down = (move.y - last_move_->y) / picture_height;
    if (move.left) {
      orbit_->orbit(right, down);
    } else if (move.right || move.middle) {
      orbit_->pan(right, down);
    }
  }
  last_move_ = move;
}

renderer::VirtualCamera Eye::at(std::uint64_t view_index, Instant now) {
  renderer::VirtualCamera camera;
  camera.lens = lens_;
  camera.world_from_eye = viewpoint_->at(view_index, now).world_from_eye;
  return camera;
}

void Eye::log_news(Instant now) {
  while (const auto news = viewpoint_->news(now)) {
    spdlog::log(news->is_trouble ? spdlog::level::warn : spdlog::level::info, "{}", news->text);
  }
}

}  // namespace copresence::client
