#include "render_client/display/controls.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace copresence::display {
namespace {

using window::Key;

constexpr std::array kControls{
    Control{"drag with the left button", "turns the view around the point in its middle", {}},
    Control{"drag with the right or middle button", "moves the view sideways, up and down", {}},
    Control{"wheel", "moves nearer or farther", {}},
    Control{"R or Home", "goes back to the first camera's pose", Command::kResetPose, {Key{'R'}, Key::kHome}},
    Control{
        "F1", "shows figures of the cameras and the view, and hides them", Command::kShowFigures, {Key::kF1}},
    Control{"M",
            "merges cameras by blending, by the best pixel or by the nearest pixel",
            Command::kNextMerge,
            {Key{'M'}}},
    Control{"C", "switches the correction of colours off and on", Command::kCorrectColors, {Key{'C'}}},
    Control{"U", "shows unseen surfaces extended, dimmed or black", Command::kNextUnseen, {Key{'U'}}},
    Control{"L", "colours the view by camera, and back", Command::kColorByCamera, {Key{'L'}}},
    Control{"Q", "colours the view by quality, and back", Command::kColorByQuality, {Key{'Q'}}},
    Control{"W",
            "shows the sides of triangles (OpenGL renderer only), and back",
            Command::kWireframe,
            {Key{'W'}}},
    Control{"S", "goes on to the next kind of stereo", Command::kNextStereo, {Key{'S'}}},
    Control{"P",
            "saves a screenshot in the folder where the client was started",
            Command::kSaveScreenshot,
            {Key{'P'}}},
    Control{"H", "lists the keys in the window, and hides the list", Command::kListKeys, {Key{'H'}}},
    Control{"Space", "pauses a replay, or goes on", Command::kReplayPause, {Key::kSpace}},
    Control{".", "pauses a replay, and goes on to its next frame", Command::kReplayStep, {Key{'.'}}},
    Control{"[", "halves the speed of a replay", Command::kReplaySlower, {Key{'['}}},
    Control{"]", "doubles the speed of a replay", Command::kReplayFaster, {Key{']'}}},
    Control{"Left", "goes back by 5 seconds in a replay", Command::kReplayBack, {Key::kLeft}},
    Control{"Right", "goes forward by 5 seconds in a replay", Command::kReplayForward, {Key::kRight}},
    Control{
        "Backspace", "goes back to the beginning of a replay", Command::kReplayRestart, {Key::kBackspace}},
    Control{"F11", "switches full screen on and off", Command::kFullScreen, {Key::kF11}},
    Control{"Escape", "ends the client", Command::kEnd, {Key::kEscape}},
};

}  // namespace

std::span<const Control> controls() {
  return kControls;
}

std::optional<Command> command_of(const window::KeyEvent& event) {
  if (!event.pressed || event.repeated || event.modifiers.control || event.modifiers.alt ||
      event.key == Key::kUnknown) {
    return std::nullopt;
  }
  for (const Control& control : kControls) {
    if (std::find(control.keys.begin(), control.keys.end(), event.key) != control.keys.end())
      return control.command;
  }
  return std::nullopt;
}

overlay::Switch switch_of(Command command, std::string name, std::string state) {
  const auto control = std::find_if(kControls.begin(), kControls.end(),
                                    [&](const Control& each) { return each.command == command; });
  assert(control != kControls.end());
  return {static_cast<int>(command), control->input, std::move(name), std::move(state)};
}

}  // namespace copresence::display
