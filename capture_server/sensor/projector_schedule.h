#pragma once

// When each camera of a room may light it. Depth cameras that find a projected pattern disturb each other where their
// patterns overlap; taking turns ends that, at the price of frame rate.
//
// Time since the epoch of the system clock is cut into turns of equal length, which go round: every server reads the
// schedule off its own clock and none talks to another. Servers of one machine share that clock; those of several agree
// as far as their clocks do (NTP: about a millisecond in one building), and a dark moment at the end of each turn covers it.
//
// Source: thesis 2.4.3 (software scheduling of projectors, after its reference [21]).
// Thread: a value.

#include <cassert>
#include <chrono>

namespace copresence::sensor {

/// Turn `index` (from 0) of `count`.
struct ProjectorSlot {
  static constexpr int kMost = 8;
  static constexpr std::chrono::milliseconds kShortest{100}, kLongestRound{3000};

  int index = 0;
  int count = 2;
  std::chrono::milliseconds turn{500};

  /// How long it takes until everybody has had a turn.
  constexpr std::chrono::milliseconds round() const { return turn * count; }

  /// A round must end before anybody takes a dark camera for a stalled one.
  constexpr bool is_sensible() const {
    return count >= 1 && count <= kMost && index >= 0 && index < count && turn >= kShortest &&
           round() <= kLongestRound;
  }
};

class ProjectorSchedule {
 public:
  using Time = std::chrono::microseconds;  ///< since the epoch of the system clock

  /// At the end of each turn nobody shines.
  static constexpr std::chrono::milliseconds kBetweenTurns{5};

  /// Requires slot.is_sensible().
  explicit ProjectorSchedule(const ProjectorSlot& slot) : slot_(slot) { assert(slot.is_sensible()); }

  bool shines(Time now) const {
    return now.count() >= 0 && now / slot_.turn % slot_.count == slot_.index &&
           now % slot_.turn < slot_.turn - kBetweenTurns;
  }

  /// From `now` to the next change of shines(), or a little less where nothing changes at a turn's end.
  Time until_change(Time now) const {
    const Time into_turn = now % slot_.turn;
    return (shines(now) ? slot_.turn - kBetweenTurns : Time(slot_.turn)) - into_turn;
  }

 private:
  ProjectorSlot slot_;
};

}  // namespace copresence::sensor
