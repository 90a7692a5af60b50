#pragma once

// The person in front of a window of the virtual display: sends what a mouse and a keyboard would
// send, and sees what is on the screen.

#include <string>

#include "common/frame/image.h"

namespace copresence {

class WindowUser {
 public:
  /// Finds the window whose title begins with `title`. There is no window manager on the display.
  explicit WindowUser(const std::string& title);
  ~WindowUser();
  WindowUser(const WindowUser&) = delete;
  WindowUser& operator=(const WindowUser&) = delete;

  bool has_window() const { return window_ != 0; }

  /// `button` is the number of X: 1 left, 2 middle, 3 right, 4 wheel up. `modifiers` is a mask of X.
  void press(unsigned button, int x, int y, unsigned modifiers = 0);
  void release(unsigned button, int x, int y, unsigned modifiers = 0);
  void move(int x, int y);
  void press_key(const std::string& keysym);  ///< As in X: "r", "F1", "Escape".
  void click_close();
  void resize(unsigned width, unsigned height);

  /// Returns what is really on the screen, or an empty image if the window is smaller or hidden.
  Image<Rgba8> see(int width, int height) const;

 private:
  void send_button(int type, unsigned button, int x, int y, unsigned modifiers);

  void* display_;         // A Display of X.
  unsigned long window_;  // 0 if there is no such window.
  unsigned long key_time_ = 0;
};

}  // namespace copresence
