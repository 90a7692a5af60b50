#pragma once

// Decides which frames a busy stage drops, so that the stage works on recent frames. Thread: pure
// functions.

#include "common/frame/rgbd_frame.h"

namespace copresence::flow {

/// True if a frame that arrived at `came` should be dropped when its worker becomes free at `free`.
/// The frame has then waited longer than half a `period`, so the next frame is due in less than
/// that time. A frame that arrives later than `free` is kept. So two frames in a row are never
/// dropped.
constexpr bool should_drop_stale(Instant came, Instant free, Duration period) {
  return free - came > period / 2;
}

}  // namespace copresence::flow
