#pragma once

// Fades a camera that sends no new frames, so that an old picture does not look live.
//
// A camera is stale if its newest frame arrived longer ago than a third of the time of --stale, by
// default 1 s. Then its opacity falls linearly. It is 0 after the time of --stale, by default 3 s.
// The age is measured from the arrival, so a camera with a slow but steady connection is not stale.
// A camera with a low frame rate starts to fade after two frame periods and is gone after three.
// Thread: one thread at a time.

#include <cstddef>
#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

class StaleCameras {
 public:
  /// Requires gone_after > 0.
  StaleCameras(std::size_t cameras, Duration gone_after) : gone_after_(gone_after), cameras_(cameras) {}

  /// Call it when a frame has arrived. `period` is the camera's nominal frame period.
  void frame_arrived(std::size_t camera, Duration period, Instant now);

  /// Returns the opacity of the camera, from 0 to 1. It is 1 before the camera's first frame.
  float opacity(std::size_t camera, Instant now) const;

  /// Returns when a view that was drawn at `drawn_at` must be redrawn because cameras fade. Returns
  /// nothing if no camera will fade.
  std::optional<Instant> next_view(Instant drawn_at) const;

  enum class Change { kStale, kBack };
  struct Event {
    std::size_t camera;
    Change change;
    bool worth_saying;  ///< False if a change of the camera was logged a short time ago.
  };
  /// Returns the cameras that have become stale or have come back since the last call.
  std::vector<Event> changes(Instant now);

 private:
  struct Camera {
    std::optional<Instant> newest;
    Duration period{};
    bool is_stale = false;
    bool is_said = false;  // Whether the log says that the camera is stale.
    std::optional<Instant> said_at;
  };
  Instant fades_from(const Camera& camera) const;
  Instant gone_from(const Camera& camera) const;

  Duration gone_after_;
  std::vector<Camera> cameras_;
};

}  // namespace copresence::pacing
