#pragma once

// Chooses one frame of each camera for a view, so that all are of nearly the same instant (--sync).
//
// The cameras have different phases. For each frame of one camera, a second camera of the same rate
// has a frame within half a period. With more cameras, the choice with the smallest span spans less
// than a period. The rule is to take the newest choice that spans at most half a period. If there
// is none, the newest of the choices with the smallest span is taken.
//
// So a frame waits for frames of other cameras, but never longer than half a period. Then it is
// shown with the nearest frames that exist, so that a stopped camera delays no other. If the
// cameras' rates differ, half of the longest period is the limit. Between two frames of the slowest
// camera, frames of the others are shown while they lie within half of that period. Thread: pure
// functions.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

/// The frames that one camera can show.
struct CameraOffer {
  /// Capture times of the frame in the last view, if any, and of the frames after it, in rising
  /// order. The times of all cameras are on the same clock.
  std::vector<Instant> captured;
  bool first_is_on_view = false;  ///< Whether captured.front() is in the last view.
  Instant fresh_since{};          ///< Arrival of the oldest frame not yet shown.
  bool delivers = true;           ///< If false, the camera has stopped.

  bool has_fresh() const { return captured.size() > (first_is_on_view ? 1u : 0u); }
};

struct FrameChoice {
  /// Indices into `captured` by camera; nothing where `captured` is empty.
  std::vector<std::optional<std::size_t>> frames;
  bool is_new = false;  ///< Whether the choice differs from the frames in the last view.
  Duration skew{};      ///< From the earliest to the latest frame of the cameras that deliver.
  /// Time of the next choice if no frame arrives earlier. Nothing if no frame is waiting.
  std::optional<Instant> at_latest;
};

/// Chooses the frames. `period` > 0 is the longest frame period of the cameras.
FrameChoice nearest_instants(std::span<const CameraOffer> offers, Duration period, Instant now);

}  // namespace copresence::pacing
