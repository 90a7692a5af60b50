#pragma once

// The viewer's eye: the viewpoint that --view names, seen through the lens that --size and --fov give; and
// what the mouse does to it.
//
// Thread: the render thread's.

#include <memory>
#include <optional>
#include <vector>

#include "common/result.h"
#include "common/scene/scene.h"
#include "common/window/event.h"
#include "render_client/renderer/merged_view.h"
#include "render_client/settings.h"
#include "render_client/viewpoint/opentrack_view.h"
#include "render_client/viewpoint/orbit_view.h"

namespace copresence::client {

class Eye {
 public:
  /// Fails where the path file is none, or the head tracker's port is in use.
  static Result<Eye> open(const ClientSettings& settings, const scene::Scene* scene);

  /// Where a camera stands. The eye is at home at the first listed camera, or until that is there at the
  /// first to come.
  void see_camera(std::size_t index, const Rigid3& world_from_camera);

  /// Left drag orbits, right or middle drag pans, the wheel comes closer, R or Home goes home.
  /// `picture_height`: of the window, pixels.
  void handle(const std::vector<window::Event>& events, int picture_height);

  renderer::VirtualCamera at(std::uint64_t view_index, Instant now);

  /// Writes to the log what the viewpoint has to say. To be called a few times a second, views or not.
  void log_news(Instant now);

  /// What came from the head tracker, where --view names one.
  const viewpoint::OpentrackView::Counters* head_tracker() const {
    return tracker_ ? &tracker_->counters() : nullptr;
  }

 private:
  Eye(const CameraModel& lens, std::unique_ptr<viewpoint::Viewpoint> viewpoint)
      : lens_(lens),
        viewpoint_(std::move(viewpoint)),
        orbit_(dynamic_cast<viewpoint::OrbitView*>(viewpoint_.get())),
        tracker_(dynamic_cast<viewpoint::OpentrackView*>(viewpoint_.get())) {}
  void drag(const window::MoveEvent& move, int picture_height);

  CameraModel lens_;
  std::unique_ptr<viewpoint::Viewpoint> viewpoint_;
  viewpoint::OrbitView* orbit_;                 // the viewpoint, where it is the mouse's
  viewpoint::OpentrackView* tracker_;           // the viewpoint, where it is a head tracker's
  std::optional<std::size_t> home_;             // index of the camera at which home is
  std::optional<window::MoveEvent> last_move_;  // where the pointer was
};

}  // namespace copresence::client
