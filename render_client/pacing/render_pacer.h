#pragma once

// Decides when the client renders, so that frames of several cameras wait as little as can be for a view.
//
// Cameras deliver at the same rate but at phases of their own, and a view shows whatever is there. With views
// as frequent as frames, a view right after one camera's frame leaves the frames of the others waiting; the
// longest wait is shortest when views follow the frame that comes before the longest gap without any. That
// camera is the anchor, the others ride along. Where more views than one are allowed in a camera's period
// there are as many anchors.
//
// Jitter: a rider that is late is waited for a little, not left for the next view; so is an anchor. A camera
// that stopped is forgotten after some frames. Views may come early as long as their mean rate stays (a token
// bucket), so that jitter never adds up to lag.
//
// Time comes in as an argument. Thread: one at a time.

#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/pacing/arrival_clock.h"

namespace copresence::pacing {

class RenderPacer {
 public:
  /// At most `views_per_second` in the mean, 1 % more where cameras are that much faster than they say.
  /// Requires cameras >= 1, views_per_second > 0.
  RenderPacer(int cameras, double views_per_second);

  /// A camera's newest frame can be shown from now on. Requires 0 <= camera < cameras.
  void frame_arrived(int camera, Instant now);

  /// When to render next as things stand: `now` or earlier means at once; nothing, while nothing new has
  /// come. Ask again after every frame_arrived() and rendered().
  std::optional<Instant> next_render_at(Instant now);

  /// A view was begun with all frames that had arrived by then.
  void rendered(Instant start);

 private:
  struct Camera {
    ArrivalClock clock;
    bool fresh = false;   // a frame that no view has shown
    bool passed = false;  // its turn as an anchor went by for want of a token: its next frame counts
    bool anchor = false;
  };

  /// When a group of cameras is complete, and when it will be the next time.
  struct Turn {
    Instant at;
    Instant next;
    Camera* anchor = nullptr;
  };

  Camera& camera_at(std::size_t place) { return cameras_[static_cast<std::size_t>(round_[place])]; }
  const Camera& camera_at(std::size_t place) const {
    return cameras_[static_cast<std::size_t>(round_[place])];
  }
  void choose_anchors(Instant now);
  Turn next_turn(Instant now);

  std::vector<Camera> cameras_;
  std::vector<int> round_;  // running cameras by phase, an anchor last
  double views_per_second_;
  Instant next_token_{};  // a view may begin at this instant; up to kEarly later ones are kept
};

}  // namespace copresence::pacing
