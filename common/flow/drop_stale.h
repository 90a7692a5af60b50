#pragma once

// What is left out where there is more than can be worked on, so that what is worked on is fresh.
//
// Thread: pure.

#include "common/frame/rgbd_frame.h"

namespace copresence::flow {

/// Whether a frame that came at `came`, and has waited for a worker who became free at `free`, is better left out: the next
/// one, due a `period` after it, is nearer than this one is old. Never so for one that came after the worker was free, so of
/// two frames in a row one is always worked on.
constexpr bool should_drop_stale(Instant came, Instant free, Duration period) {
  return free - came > period / 2;
}

}  // namespace copresence::flow
