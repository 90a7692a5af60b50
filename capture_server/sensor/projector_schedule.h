#pragma once

// Decides when the projector of each camera may be on. Structured-light cameras interfere where
// their patterns overlap. Taking turns prevents that at the cost of frame rate.
//
// The time of the system clock is divided into slots of equal length, which the cameras use in
// turn. Every server reads the schedule from its own clock, so servers need not communicate. The
// clocks of several machines differ (with NTP by about a millisecond within a building). A short
// guard time at the end of each slot covers the difference.
//
// Source: thesis section 2.4.3 (software scheduling of projectors, after its reference [21]).
// Thread: one thread at a time per object.

#include <cassert>
#include <chrono>

namespace copresence::sensor {

/// Time slot `index` (from 0) of `count` slots of equal length.
struct ProjectorSlot {
  static constexpr int kMost = 8;
  static constexpr std::chrono::milliseconds kShortest{100}, kLongestRound{3000};

  int index = 0;
  int count = 2;
  std::chrono::milliseconds length{500};

  /// Length of a round. Every camera has one slot in each round.
  constexpr std::chrono::milliseconds round() const { return length * count; }

  /// True if the slot can be used. A round must be shorter than the stall timeout of a camera.
  constexpr bool is_sensible() const {
    return count >= 1 && count <= kMost && index >= 0 && index < count && length >= kShortest &&
           round() <= kLongestRound;
  }
};

class ProjectorSchedule {
 public:
  using Time = std::chrono::microseconds;  ///< Time since the epoch of the system clock.

  /// At the end of each slot all projectors are off for this long.
  static constexpr std::chrono::milliseconds kGuard{5};

  explicit ProjectorSchedule(const ProjectorSlot& slot) : slot_(slot) { assert(slot.is_sensible()); }

  bool is_on(Time now) const {
    return now.count() >= 0 && now / slot_.length % slot_.count == slot_.index &&
           now % slot_.length < slot_.length - kGuard;
  }

  /// Time from `now` to the next change of is_on() or the end of the slot, whichever is first.
  Time until_change(Time now) const {
    const Time into_slot = now % slot_.length;
    return (is_on(now) ? slot_.length - kGuard : Time(slot_.length)) - into_slot;
  }

 private:
  ProjectorSlot slot_;
};

}  // namespace copresence::sensor
