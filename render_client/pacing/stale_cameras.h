#pragma once

// Fades a camera from the view while no new frame of it comes, so that an old picture does not pass for a
// live one.
//
// A camera is stale once its newest frame is older than a third of the time that --stale gives: by default
// after 1 s. From then on its opacity falls linearly, and it is 0 after the whole time: by default after 3 s.
// A frame's age counts from its arrival, so that a slow but steady connection is not stale. Where frames are
// rare the camera gets at least two of its frame periods before it fades and three before it is gone.
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

  /// A new frame of the camera has arrived. `period`: nominal time between its frames.
  void frame_arrived(std::size_t camera, Duration period, Instant now);

  /// How much of the camera is drawn: 1 all of it, 0 nothing, in between a faded picture. 1 before its first
  /// frame.
  float opacity(std::size_t camera, Instant now) const;

  /// When a view that was drawn at `drawn_at` is to be drawn anew although no frame comes; nothing if never.
  std::optional<Instant> next_view(Instant drawn_at) const;

  enum class Change { kStale, kBack };
  struct Event {
    std::size_t camera;
    Change change;
    bool worth_saying;  ///< false: said not long ago, keep it out of the log
  };
  /// The cameras that have become stale or come back since the last call.
  std::vector<Event> changes(Instant now);

 private:
  struct Camera {
    std::optional<Instant> newest;
    Duration period{};
    bool is_stale = false;
    bool is_said = false;  // that it is stale
    std::optional<Instant> said_at;
  };
  Instant fades_from(const Camera& camera) const;
  Instant gone_from(const Camera& camera) const;

  Duration gone_after_;
  std::vector<Camera> cameras_;
};

}  // namespace copresence::pacing
