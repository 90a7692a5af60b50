#pragma once

// Which frames of several cameras make one view, when they are to be of nearly one instant (--sync).
//
// Cameras deliver at phases of their own. Of two cameras of one rate, every frame has one of the other's
// within half a period before or after it; of more, the narrowest choice spans less than a period. The rule:
// the newest choice that spans at most half a period; where there is none, the newest of the narrowest. So a
// frame whose neighbour is still under way waits for it, but never longer than half a period: then it is
// shown with the nearest there is, and a camera that stops holds up nobody. Where rates differ, the period is
// the longest, that of the slowest camera: between two of its frames the others' are shown for as long as
// they are within half of it.
//
// Time comes in as an argument. Thread: pure.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

/// What one camera has to show.
struct CameraOffer {
  std::vector<Instant> captured;  ///< on one clock, rising: the frame on view, if any, and those after it
  bool first_is_on_view = false;  ///< `captured.front()` has been shown
  Instant fresh_since{};  ///< when the oldest frame not yet shown arrived; meaningless where there is none
  bool delivers = true;   ///< its frames come; false: it stopped, and what it has stays as it is

  bool has_fresh() const { return captured.size() > (first_is_on_view ? 1u : 0u); }
};

struct FrameChoice {
  /// By camera: which of `captured`; nothing where that is empty.
  std::vector<std::optional<std::size_t>> frames;
  bool is_new = false;  ///< differs from what is on view: to be shown now
  Duration skew{};      ///< between the latest and the earliest of the cameras that deliver
  std::optional<Instant>
      at_latest;  ///< ask again then, if nothing arrives before; nothing while nothing waits
};

/// Requires period > 0: the cameras', the longest where they differ.
FrameChoice nearest_instants(std::span<const CameraOffer> offers, Duration period, Instant now);

}  // namespace copresence::pacing
