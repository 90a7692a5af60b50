#pragma once

// The keys and mouse actions of the viewer's window. The program's help, the list in the window and
// docs/guide/keys.md agree with this table. Thread: pure functions.

#include <array>
#include <optional>
#include <span>
#include <string>

#include "common/window/event.h"
#include "render_client/display/overlay/overlay.h"

namespace copresence::display {

enum class Command {
  kResetPose,
  kShowFigures,
  kNextMerge,
  kCorrectColors,
  kNextUnseen,
  kColorByCamera,
  kColorByQuality,
  kWireframe,
  kNextStereo,
  kSaveScreenshot,
  kListKeys,
  kReplayPause,
  kReplayStep,
  kReplaySlower,
  kReplayFaster,
  kReplayBack,
  kReplayForward,
  kReplayRestart,
  kFullScreen,
  kEnd,
};

struct Control {
  const char* input;  ///< The keys' names or the mouse action.
  const char* effect;
  std::optional<Command> command;     ///< Nothing for mouse actions.
  std::array<window::Key, 2> keys{};  ///< Unused elements are kUnknown.
};

/// Returns all controls in the order of the lists.
std::span<const Control> controls();

/// Returns the command of a key press, if there is one. A key with Control or Alt has none.
std::optional<Command> command_of(const window::KeyEvent& event);

/// Returns a switch of the overlay that gives the command. Its id is the command.
overlay::Switch switch_of(Command command, std::string name, std::string state);

}  // namespace copresence::display
