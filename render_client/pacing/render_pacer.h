#pragma once

// Decides when the client renders, so that frames of several cameras wait for a view as short a
// time as possible.
//
// Cameras deliver at the same rate but at different phases, and a view shows the frames that are
// there. Suppose there are as many views as frames of one camera. A view right after one camera's
// frame makes the frames of the others wait. The longest wait is shortest if views follow the frame
// before the longest gap between frames. The camera of that frame is the phase leader, and the
// others follow. If several views are allowed in a camera's period, there are as many leaders.
//
// A view waits a short time for a late leader or follower. A camera that has stopped is forgotten
// after some frames. Views may come early as long as their mean rate stays the same (a token
// bucket), so that jitter does not add up to lag.
//
// Time comes in as an argument. Thread: one at a time.

#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/pacing/arrival_clock.h"

namespace copresence::pacing {

class RenderPacer {
 public:
  /// At most `views_per_second` on average, and 1 % more for cameras that are faster than their
  /// nominal rate. Requires cameras >= 1, views_per_second > 0.
  RenderPacer(int cameras, double views_per_second);

  /// A camera's newest frame can be shown from now on. Requires 0 <= camera < cameras.
  void frame_arrived(int camera, Instant now);

  /// When to render next, as far as is known; `now` or earlier means at once. Nothing if there is
  /// no new frame. Ask again after every frame_arrived() and rendered().
  std::optional<Instant> next_render_at(Instant now);

  /// A view has begun with all frames that have arrived.
  void rendered(Instant start);

 private:
  struct Camera {
    ArrivalClock clock;
    bool fresh = false;   // no view has shown its newest frame
    bool passed = false;  // it led and had no token, so the view waits for its next frame
    bool leader = false;
  };

  /// When a group of cameras is complete, and when it will be complete the next time.
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
  std::vector<int> round_;  // running cameras by phase; a leader is the last
  double views_per_second_;
  Instant next_token_{};  // a view may begin at this time; up to kEarly later tokens are kept
};

}  // namespace copresence::pacing
