#pragma once

// The position of a replay in a window: real time, pause, steps, speed and jumps. Thread: one thread
// at a time.

#include <functional>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/matroska/matroska.h"

namespace copresence::session {

using matroska::Time;

enum class ReplayCommand {
  kPause,    ///< Pauses, or continues.
  kStep,     ///< Pauses, and goes on to the next frame of any camera.
  kSlower,   ///< Halves the speed.
  kFaster,   ///< Doubles the speed.
  kBack,     ///< Jumps back by kJump.
  kForward,  ///< Jumps forward by kJump.
  kRestart,  ///< Jumps to the beginning.
};

class ReplayControl {
 public:
  static constexpr std::chrono::seconds kJump{5};
  static constexpr double kSlowest = 0.125, kFastest = 8;

  /// The recording lasts from `begin` to `end`. `next_frame_after` is Playback::next_frame_after().
  ReplayControl(Time begin, Time end, std::function<std::optional<Time>(Time)> next_frame_after);

  /// Returns true if the position jumps.
  bool apply(ReplayCommand command);

  /// Returns the position at `now`, an instant of this process's clock. It stops at the end.
  Time position(Instant now);

  /// Returns the state for the window's title, for example "0:12 of 1:05, paused, 2x".
  std::string text() const;

 private:
  Time begin_, end_;
  std::function<std::optional<Time>(Time)> next_frame_after_;
  std::chrono::duration<double, Time::period> position_;  // With fractions, for slow replays.
  double speed_ = 1;
  bool is_paused_ = false;
  std::optional<Instant> last_;
};

}  // namespace copresence::session
