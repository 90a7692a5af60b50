#pragma once

// Moves the position of a replay: in real time and by commands in a window, or from view to view without
// a window. Thread: the render thread.

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "render_client/display/controls.h"
#include "render_client/session/playback.h"
#include "render_client/session/replay_control.h"
#include "render_client/stream/camera_states.h"

namespace copresence::client {

class Replay {
 public:
  /// Views of the replay begin when all cameras have a frame that begin within this time. Views do
  /// not wait for cameras that join later.
  static constexpr std::chrono::seconds kStartTogether{2};

  /// All referenced objects must outlive the replay.
  Replay(session::Playback& playback, stream::CameraStates& states);

  /// Moves to the position in real time, after the user's commands.
  void follow(std::span<const display::Command> commands, Instant now);
  /// The state for the window's title.
  std::string text() const { return control_.text(); }

  /// Moves to the next view and waits until all frames up to it have been taken. Views have a fixed
  /// rate on the recording's clock. The last view shows the last frame. Returns false after it, and
  /// if a stop is requested.
  bool next_view(double views_per_second, std::stop_token stop);

 private:
  session::Playback& playback_;
  session::ReplayControl control_;
  session::Time first_view_;
  session::Time last_view_;  // Before the first view, the time before the recording.
  std::uint64_t views_ = 0;
};

}  // namespace copresence::client
