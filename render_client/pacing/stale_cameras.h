#pragma once

// Fades a camera from the view while no new frame of it comes, so that an old picture does not look
// live.
//
// A camera is stale once its newest frame is older than a third of the time of --stale: by default
// after 1 s. Its opacity then falls linearly, and is 0 after the whole time: by default after 3 s.
// Age counts from the frame's arrival, so that a slow but steady connection is not stale. A camera
// with few frames does not fade before two of its frame periods, and is not gone before three.
//
// Time comes in as an argument. Thread: one at a time.

#include <cstddef>
#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

class StaleCameras {
 public:
  /// Requires gone_after > 0.
  StaleCameras(std::size_t cameras, Duration gone_after) : gone_after_(gone_after), cameras_(cameras) {}

  /// A new frame of the camera has arrived. `period` is the nominal time between its frames.
  void frame_arrived(std::size_t camera, Duration period, Instant now);

  /// Opacity of the camera: 1 is opaque, 0 is not drawn. 1 before its first frame.
  float opacity(std::size_t camera, Instant now) const;

  /// When a view drawn at `drawn_at` is out of date because cameras fade. Nothing if none will
  /// fade.
  std::optional<Instant> next_view(Instant drawn_at) const;

  enum class Change { kStale, kBack };
  struct Event {
    std::size_t camera;
    Change change;
    bool worth_saying;  ///< false: it was logged a short time ago
  };
  /// The cameras that have become stale or have come back since the last call.
  std::vector<Event> changes(Instant now);

 private:
  struct Camera {
    std::optional<Instant> newest;
    Duration period{};
    bool is_stale = false;
    bool is_said = false;  // it was logged that the camera is stale
    std::optional<Instant> said_at;
  };
  Instant fades_from(const Camera& camera) const;
  Instant gone_from(const Camera& camera) const;

  Duration gone_after_;
  std::vector<Camera> cameras_;
};

}  // namespace copresence::pacing
