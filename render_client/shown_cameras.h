#pragma once

// Keeps the frame of each camera that the next view shows. It also decides which cameras are left
// out, and whether a view is complete. Thread: the render thread.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/flow/mailboxes.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/color_matching/live_color_matching.h"
#include "render_client/moving_surfaces/moving_surfaces.h"
#include "render_client/pacing/frame_sync.h"
#include "render_client/pacing/stale_cameras.h"
#include "render_client/renderer/renderer.h"
#include "render_client/settings.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_states.h"

namespace copresence::client {

/// Makes the renderer's input from a frame. `found` is the colour correction from live matching. A
/// correction in the scene file replaces it. `frame` must outlive the result.
renderer::CameraView camera_view(const CameraFrame& frame, std::uint64_t version,
                                 const color_matching::ColorCorrection& found);

class ShownCameras {
 public:
  /// `addresses` are those of the cameras' servers. All references must outlive this object.
  ShownCameras(const ClientSettings& settings, const std::vector<std::string>& addresses,
               const stream::CameraStates& states, std::deque<statistics::CameraStatistics>& statistics,
               color_matching::LiveColorMatching& colors);

  struct Arrival {
    std::size_t camera;
    Instant arrived_at;
    Rigid3 world_from_camera;
    CameraModel model;
  };
  /// Takes the frames that have arrived, and removes the cameras that are left out of the view.
  std::vector<Arrival> take(flow::Mailboxes<CameraFrame>& mailboxes, Instant now);

  /// Returns the cameras of the next view for Renderer::render().
  std::vector<renderer::CameraView> views(Instant now) const;
  /// Returns the number of the listed camera for each element of views().
  std::vector<std::size_t> cameras_of_views() const;

  /// Sets whether views() has colour corrections. They are on at first.
  void correct_colors(bool corrects) { corrects_colors_ = corrects; }

  std::size_t size() const { return cameras_.size(); }  ///< Number of listed cameras.
  /// Returns the camera's newest frame, or null if the view shows none.
  const CameraFrame* newest(std::size_t camera) const { return cameras_[camera].newest.get(); }
  /// Returns the opacity of a camera that has a newest frame, and 0 for other cameras.
  float opacity(std::size_t camera, Instant now) const;

  /// Returns whether a frame has come or a camera has been removed since the last view.
  bool have_changed() const;
  /// Returns whether frames wait for the next view, or for frames of other cameras (--sync).
  bool have_waiting() const;
  /// As FrameSync::wake_by().
  Instant wake_by(Instant deadline) const { return frames_.wake_by(deadline); }
  /// Returns when a view is due because a camera fades, although no frame has come.
  std::optional<Instant> next_fading_view() const;

  /// Call it after a view of these cameras was begun at `begin` and shown at `end`.
  void displayed(Instant begin, Instant end);
  std::optional<Instant> last_view_at() const { return last_view_at_; }

  /// Returns whether the view shows a camera, and all listed cameras that are not left out.
  bool are_complete() const;
  /// Returns whether live matching has set the colours for the first time, is not needed or has
  /// given up. Earlier views are not counted, since their colours may still change. Call it only
  /// while the cameras are complete.
  bool colors_are_settled(Instant now);
  /// Returns whether the colours can be matched and are not settled yet.
  bool awaits_colors() const { return !colors_settled_ && !cameras_to_match().empty(); }
  /// Returns the time between the earliest and the latest frame in the view, or nothing unless at
  /// least two cameras send frames.
  std::optional<Duration> skew(Instant now) const;

 private:
  struct Camera {
    std::shared_ptr<const CameraFrame> newest;
    std::uint64_t version = 0;  // The CameraView::version of `newest`.
    std::shared_ptr<const RgbdFrame> remembered;
    std::uint64_t remembered_version = 0;  // The CameraView::version of `remembered`.
    bool is_fresh = false;                 // Whether no view has shown `newest` yet.
    bool said_no_pose = false;
  };
  void show(std::size_t camera, CameraFrame frame, Instant now);
  /// Leaves out the moving surfaces of a new frame that another camera shows better.
  void leave_out_moving_surfaces(std::size_t camera, CameraFrame& frame, Instant now);
  void remove(std::size_t camera);
  void note_stale_cameras(Instant now);
  /// Returns the cameras whose colours are matched live, or none if there are fewer than two.
  std::vector<std::size_t> cameras_to_match() const;

  const ClientSettings& settings_;
  const std::vector<std::string>& addresses_;
  const stream::CameraStates& states_;
  std::deque<statistics::CameraStatistics>& statistics_;
  color_matching::LiveColorMatching& colors_;
  pacing::FrameSync frames_;
  pacing::StaleCameras stale_;
  moving_surfaces::MovingSurfaces moving_surfaces_;
  std::vector<Camera> cameras_;
  std::uint64_t versions_ = 0;  // The greatest CameraView::version so far.
  bool corrects_colors_ = true;
  bool was_removed_ = false;  // Whether a camera has been removed since the last view.
  std::optional<Instant> last_view_at_;
  std::optional<Instant> complete_since_;
  bool colors_settled_ = false;
};

}  // namespace copresence::client
