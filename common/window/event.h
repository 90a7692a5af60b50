#pragma once

// What a person does to a window. Positions are pixels of its picture from the top left, fractions included,
// also on displays where the window system counts in coarser units.

#include <cstdint>
#include <variant>

namespace copresence::window {

/// Printable keys have their character on a US keyboard, letters in upper case: Key{'R'}.
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

/// The pointer moved; `left`, `right`, `middle` are held: a drag.
struct MoveEvent {
  double x, y;
  bool left, right, middle;
  Modifiers modifiers;
};

/// A wheel or a touchpad, in notches; y > 0 is away from the person.
struct ScrollEvent {
  double x, y;
};

struct KeyEvent {
  Key key;
  bool pressed;
  bool repeated;  ///< the key is being held down
  Modifiers modifiers;
};

/// The picture's new size, pixels; 0 while the window is an icon.
struct ResizeEvent {
  int width, height;
};

using Event = std::variant<ButtonEvent, MoveEvent, ScrollEvent, KeyEvent, ResizeEvent>;

}  // namespace copresence::window
