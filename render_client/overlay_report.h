#pragma once

// Gathers what the window shows over the view: why cameras are not shown, figures of the cameras and
// of the view, and the result of the user's last action. Thread: the render thread.

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/flow/latency_histogram.h"
#include "common/scene/scene.h"
#include "render_client/display/overlay/overlay.h"
#include "render_client/renderer/renderer.h"
#include "render_client/shown_cameras.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_states.h"

namespace copresence::client {

class OverlayReport {
 public:
  /// The referenced objects must outlive this one. `scene` may be null.
  OverlayReport(const stream::CameraStates& states,
                const std::deque<statistics::CameraStatistics>& statistics, const ShownCameras& cameras,
                const scene::Scene* scene);

  /// Call it after a view was drawn. `shares` is nothing if the renderer does not count pixels.
  void view_drawn(Instant begin, Instant end, const std::optional<renderer::OriginShares>& shares);

  /// Shows this text for some seconds.
  void say(std::string message, Instant now);

  /// Returns the content for a view at `now`. The figures are those of the last whole second.
  overlay::Content content(Instant now);

 private:
  struct Camera {
    statistics::CameraStatistics::Snapshot before;
    std::deque<std::vector<float>> stages_ms;  // By second, then by stage. The last stage is the rest.
    std::optional<double> disagreement_mm;
  };
  std::vector<std::string> notices(Instant now) const;
  void update_figures(Instant now, Duration elapsed);
  overlay::CameraLine camera_line(std::size_t index, Instant now, Duration elapsed);
  std::vector<overlay::Row> view_rows(Instant now, Duration elapsed) const;
  void compare_next_camera();

  const stream::CameraStates& states_;
  const std::deque<statistics::CameraStatistics>& statistics_;
  const ShownCameras& shown_;
  const scene::Scene* scene_;
  std::vector<Camera> cameras_;
  std::size_t next_compared_ = 0;  // Index of the camera that is compared with the others next.
  int views_ = 0;                  // Since the figures were updated.
  flow::LatencyHistogram render_time_;
  std::optional<renderer::OriginShares> shares_;  // Of the last view.
  overlay::Figures figures_;
  std::optional<Instant> figures_at_;
  std::string message_;
  Instant message_until_{};
};

}  // namespace copresence::client
