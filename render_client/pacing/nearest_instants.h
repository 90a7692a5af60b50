#pragma once

// Chooses which frames of several cameras make one view, so that they are of nearly one instant
// (--sync).
//
// Every camera delivers at its own phase. For two cameras of one rate, each frame has a frame of
// the other camera within half a period. For more cameras, the narrowest choice spans less than a
// period. The rule is: take the newest choice that spans at most half a period. If there is none,
// take the newest of the narrowest choices.
//
// So a frame whose neighbour is still on its way waits for it, but never longer than half a period.
// Then it is shown with the nearest frames there are, and a stopped camera delays no other. If
// rates differ, the period is the longest one. Between two frames of the slowest camera, the frames
// of the others are shown while they lie within half of that period.
//
// Time comes in as an argument. Thread: pure.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

/// The frames that one camera can show.
struct CameraOffer {
  /// On one clock, rising: the frame on view, if any, and the frames after it.
  std::vector<Instant> captured;
  bool first_is_on_view = false;  ///< `captured.front()` is on view
  Instant fresh_since{};          ///< arrival of the oldest frame not yet shown; meaningless if there is none
  bool delivers = true;           ///< false: the camera has stopped, and its frame stays on view

  bool has_fresh() const { return captured.size() > (first_is_on_view ? 1u : 0u); }
};

struct FrameChoice {
  /// For each camera an index into `captured`; nothing if that is empty.
  std::vector<std::optional<std::size_t>> frames;
  bool is_new = false;  ///< differs from the frames on view, so it is to be shown now
  Duration skew{};      ///< between the latest and the earliest frame of the cameras that deliver
  std::optional<Instant>
      at_latest;  ///< choose again at this time if nothing arrives before; nothing if no frame waits
};

/// `period` > 0 is the frame period of the cameras; if they differ, the longest.
FrameChoice nearest_instants(std::span<const CameraOffer> offers, Duration period, Instant now);

}  // namespace copresence::pacing
