#pragma once

// Input events of a window. Positions are in pixels of the window's picture from its top left
// corner. Positions have fractions, also if the window system counts in coarser units.

#include <cstdint>
#include <variant>

namespace copresence::window {

/// A printable key has its upper-case character on a US keyboard as its value: Key{'R'}.
enum class Key : std::uint16_t {
  kUnknown = 0,
  kSpace = ' ',
  kEscape = 256,
  kEnter,
  kTab,
  kBackspace,
  kRight,
  kLeft,
  kDown,
  kUp,
  kPageUp,
  kPageDown,
  kHome,
  kEnd,
  kF1 = 290,
  kF11 = 300,
  kF12,
};

enum class Button : std::uint8_t { kLeft, kRight, kMiddle };

struct Modifiers {
  bool shift = false, control = false, alt = false;
};

struct ButtonEvent {
  Button button;
  bool pressed;
  double x, y;
  Modifiers modifiers;
};

/// The pointer moved. `left`, `right` and `middle` are true while that button is pressed.
struct MoveEvent {
  double x, y;
  bool left, right, middle;
  Modifiers modifiers;
};

/// A wheel or a touchpad moved by this number of wheel notches. y > 0 is away from the user.
struct ScrollEvent {
  double x, y;
};

struct KeyEvent {
  Key key;
  bool pressed;
  bool repeated;  ///< True if the system repeats a pressed key.
  Modifiers modifiers;
};

/// The window's picture has a new size in pixels. The size is 0 while the window is minimised.
struct ResizeEvent {
  int width, height;
};

using Event = std::variant<ButtonEvent, MoveEvent, ScrollEvent, KeyEvent, ResizeEvent>;

}  // namespace copresence::window
