#include "render_client/replay.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace copresence::client {
namespace {

using display::Command;
using session::ReplayCommand;
using session::Time;

constexpr std::array<std::pair<Command, ReplayCommand>, 7> kCommands = {{
    {Command::kReplayPause, ReplayCommand::kPause},
    {Command::kReplayStep, ReplayCommand::kStep},
    {Command::kReplaySlower, ReplayCommand::kSlower},
    {Command::kReplayFaster, ReplayCommand::kFaster},
    {Command::kReplayBack, ReplayCommand::kBack},
    {Command::kReplayForward, ReplayCommand::kForward},
    {Command::kReplayRestart, ReplayCommand::kRestart},
}};

}  // namespace

Replay::Replay(session::Playback& playback, stream::CameraStates& states)
    : playback_(playback),
      control_(playback.file().begin(), playback.file().end(),
               [&playback](Time time) { return playback.next_frame_after(time); }),
      first_view_(playback.file().begin()),
      last_view_(first_view_ - Time(1)) {
  const auto& cameras = playback.file().cameras();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Time begin = cameras[i].streams.front().begin();
    if (begin <= playback.file().begin() + kStartTogether) {
      first_view_ = std::max(first_view_, begin);
    } else {
      states.availability(i, stream::Availability::kLeftOut, "the camera joins later in the recording");
    }
  }
}

void Replay::follow(std::span<const Command> commands, Instant now) {
  bool jumps = false;
  for (const Command given : commands) {
    for (const auto& [command, replay_command] : kCommands) {
      if (command == given) jumps = control_.apply(replay_command) || jumps;
    }
  }
  const Time position = control_.position(now);
  if (jumps) {
    playback_.seek(position);
  } else {
    playback_.advance(position);
  }
}

bool Replay::next_view(double views_per_second, std::stop_token stop) {
  if (last_view_ >= playback_.file().end()) return false;
  const std::chrono::duration<double> passed(static_cast<double>(views_++) / views_per_second);
  last_view_ = first_view_ + std::chrono::round<Time>(passed);
  playback_.advance(last_view_);
  playback_.wait_until_taken(stop);
  return !stop.stop_requested();
}

}  // namespace copresence::client
