#pragma once

// Decides when the client renders, so that the frames of all cameras wait only briefly for a view.
//
// The cameras have the same frame rate but different phases. If the view rate equals the frame
// rate, each view shows one frame of every camera, and most frames have to wait for it. The longest
// wait is shortest if the view follows the frame that precedes the longest gap between frames. The
// camera of that frame is called the phase leader, and the other cameras are followers. If n views
// are allowed per period, there are n leaders.
//
// A view waits a short time for a late leader or follower. A camera that has stopped is ignored
// after some frames. A token bucket limits the mean rate of views. Single views may be early, so
// that jitter does not accumulate as delay. Thread: one thread at a time per object.

#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/pacing/arrival_clock.h"

namespace copresence::pacing {

class RenderPacer {
 public:
  /// Allows `views_per_second` on average, and 1 % more for cameras that are faster than their
  /// nominal rate. Requires cameras >= 1 and views_per_second > 0.
  RenderPacer(int cameras, double views_per_second);

  /// Call it when a camera's newest frame can be shown. Requires 0 <= camera < cameras.
  void frame_arrived(int camera, Instant now);

  /// Returns when to render next, or nothing if there is no new frame. `now` or earlier means at
  /// once. The result is valid until the next frame_arrived() or rendered().
  std::optional<Instant> next_render_at(Instant now);

  /// Call it when a view has begun with all frames that have arrived.
  void rendered(Instant start);

 private:
  struct Camera {
    ArrivalClock clock;
    bool fresh = false;  // Whether no view has shown its newest frame.
    // Whether it was a leader and there was no token, so that its next frame is awaited.
    bool passed = false;
    bool leader = false;
  };

  /// The time at which a group of cameras is complete, and the next such time.
  struct Turn {
    Instant at;
    Instant next;
    Camera* leader = nullptr;
  };

  Camera& camera_at(std::size_t place) { return cameras_[static_cast<std::size_t>(round_[place])]; }
  const Camera& camera_at(std::size_t place) const {
    return cameras_[static_cast<std::size_t>(round_[place])];
  }
  void choose_leaders(Instant now);
  Turn next_turn(Instant now);

  std::vector<Camera> cameras_;
  std::vector<int> round_;  // The running cameras, ordered by phase. The last one is a leader.
  double views_per_second_;
  Instant next_token_{};  // Time from which the token for the next view is available.
};

}  // namespace copresence::pacing
