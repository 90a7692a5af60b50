#pragma once

// When the projector of each camera in a room may be on. Structured-light cameras interfere where
// their patterns overlap; taking turns prevents that at the cost of frame rate.
//
// Time since the epoch of the system clock is divided into slots of equal length, assigned to the
// cameras in a round robin. Every server reads the schedule off its own clock, without any
// communication. Servers on one machine share that clock. Those of several machines agree as far as
// their clocks do (NTP: about a millisecond within a building); a short guard time at the end of
// each slot covers the difference.
//
// Source: thesis 2.4.3 (software scheduling of projectors, after its reference [21]).
// Thread: a value.

#include <cassert>
#include <chrono>

namespace copresence::sensor {

/// Slot `index` (from 0) of `count`.
struct ProjectorSlot {
  static constexpr int kMost = 8;
  static constexpr std::chrono::milliseconds kShortest{100}, kLongestRound{3000};

  int index = 0;
  int count = 2;
  std::chrono::milliseconds length{500};

  /// Length of a round, in which every camera has one slot.
  constexpr std::chrono::milliseconds round() const { return length * count; }

  /// A round must be shorter than the time after which a silent camera counts as stalled.
  constexpr bool is_sensible() const {
    return count >= 1 && count <= kMost && index >= 0 && index < count && length >= kShortest &&
           round() <= kLongestRound;
  }
};

class ProjectorSchedule {
 public:
  using Time = std::chrono::microseconds;  ///< since the epoch of the system clock

  /// At the end of each slot all projectors are off for this long.
  static constexpr std::chrono::milliseconds kGuard{5};

  /// Requires slot.is_sensible().
  explicit ProjectorSchedule(const ProjectorSlot& slot) : slot_(slot) { assert(slot.is_sensible()); }

  bool is_on(Time now) const {
    return now.count() >= 0 && now / slot_.length % slot_.count == slot_.index &&
           now % slot_.length < slot_.length - kGuard;
  }

  /// From `now` to the next change of is_on(), or to the end of the present slot if that comes
  /// first.
  Time until_change(Time now) const {
    const Time into_slot = now % slot_.length;
    return (is_on(now) ? slot_.length - kGuard : Time(slot_.length)) - into_slot;
  }

 private:
  ProjectorSlot slot_;
};

}  // namespace copresence::sensor
