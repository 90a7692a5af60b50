#pragma once

// The cameras as the render thread sees them: which frame of each the next view shows, and whether
// the view is complete.
//
// Thread: the render thread.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/flow/mailboxes.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/color_matching/live_color_matching.h"
#include "render_client/pacing/frame_sync.h"
#include "render_client/pacing/stale_cameras.h"
#include "render_client/renderer/renderer.h"
#include "render_client/settings.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_states.h"

namespace copresence::client {

/// A frame as the renderer takes it; `version` as in CameraView. The correction of the scene file
/// replaces `found`, which live matching has found. `frame` must outlive the result.
renderer::CameraView camera_view(const CameraFrame& frame, std::uint64_t version,
                                 const color_matching::ColorCorrection& found);

class ShownCameras {
 public:
  /// `addresses` of the cameras' servers. All references must outlive this.
  ShownCameras(const ClientSettings& settings, const std::vector<std::string>& addresses,
               const stream::CameraStates& states, std::deque<statistics::CameraStatistics>& statistics,
               color_matching::LiveColorMatching& colors);

  /// A camera has a new frame for the next view.
  struct Arrival {
    std::size_t camera;
    Instant arrived_at;
    Rigid3 world_from_camera;
    CameraModel model;
  };
  /// Takes the frames that have arrived, and removes cameras that are left out of the view.
  std::vector<Arrival> take(flow::Mailboxes<CameraFrame>& mailboxes, Instant now);

  /// What the next view shows, for Renderer::render().
  std::vector<renderer::CameraView> views(Instant now) const;

  /// Whether a frame is there that no view has shown, or a camera has been removed since the last
  /// view.
  bool have_changed() const;
  /// Whether frames wait for the next view, or for frames of other cameras (--sync).
  bool have_waiting() const;
  /// As FrameSync::wake_by().
  Instant wake_by(Instant deadline) const { return frames_.wake_by(deadline); }
  /// When a view is due although no frame has come, because a camera fades.
  std::optional<Instant> next_fading_view() const;

  /// A view of these cameras, begun at `begin`, has been shown at `end`.
  void displayed(Instant begin, Instant end);
  /// When the last view was begun.
  std::optional<Instant> last_view_at() const { return last_view_at_; }

  /// Whether the view shows at least one camera, and every listed one that is not left out.
  bool are_complete() const;
  /// Whether the colours are matched, need no matching, or will not be matched. Until then views
  /// are not counted, since their colours are about to change. Call it only while the cameras are
  /// complete.
  bool colors_are_settled(Instant now);
  /// Whether the colours can be matched and are not settled yet.
  bool awaits_colors() const { return !colors_settled_ && !cameras_to_match().empty(); }
  /// Time between the earliest and the latest frame in the view. Nothing unless two cameras send
  /// frames.
  std::optional<Duration> skew(Instant now) const;

 private:
  struct Camera {
    std::shared_ptr<const CameraFrame> newest;
    std::uint64_t version = 0;  // of `newest`; unique over all cameras
    bool is_fresh = false;      // no view has shown `newest`
    bool said_no_pose = false;
  };
  void show(std::size_t camera, CameraFrame frame);
  void remove(std::size_t camera);
  void note_stale_cameras(Instant now);
  /// The cameras whose colours are matched live; none if there are fewer than two.
  std::vector<std::size_t> cameras_to_match() const;

  const ClientSettings& settings_;
  const std::vector<std::string>& addresses_;
  const stream::CameraStates& states_;
  std::deque<statistics::CameraStatistics>& statistics_;
  color_matching::LiveColorMatching& colors_;
  pacing::FrameSync frames_;
  pacing::StaleCameras stale_;
  std::vector<Camera> cameras_;
  std::uint64_t frames_taken_ = 0;
  bool was_removed_ = false;  // the last view shows a camera that has been removed since
  std::optional<Instant> last_view_at_;
  std::optional<Instant> complete_since_;
  bool colors_settled_ = false;
};

}  // namespace copresence::client
