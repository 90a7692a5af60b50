#pragma once

// Draws text, figures and switches over the window's picture. It takes the window's events, so that a
// drag that begins on a panel does not move the view. Thread: the thread of the OpenGL context.

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/gl/context.h"
#include "common/window/event.h"

namespace copresence::overlay {

/// A line of two columns: a key and its effect, or a figure and its value.
struct Row {
  std::string name, value;
};

/// The figures of one camera.
struct CameraLine {
  std::vector<std::string> cells;  ///< As many as Figures::headings.
  /// A graph of the stages' times in milliseconds, one column for each interval, the oldest first. A
  /// column has as many numbers as Figures::stages.
  std::deque<std::vector<float>> stages_ms;
};

struct Figures {
  std::vector<std::string> headings;
  std::vector<CameraLine> cameras;
  std::vector<std::string> stages;  ///< Names of the stages, in the order of a frame's way.
  std::vector<Row> view;
};

/// A button that shows a setting and changes it.
struct Switch {
  int id = 0;       ///< Returned by take_clicks().
  std::string key;  ///< The key that does the same.
  std::string name, state;
};

struct Content {
  /// Why cameras are not shown, one sentence each. They are always visible.
  std::vector<std::string> notices;
  /// The result of the user's last action, or empty. It is always visible.
  std::string message;
  Figures figures;                 ///< Visible after toggle_figures().
  std::vector<Switch> switches{};  ///< Below the figures.
};

class Overlay {
 public:
  /// `keys` are the lines of the list of keys. `context` must outlive the overlay. At most one
  /// overlay exists at a time.
  Overlay(gl::Context& context, std::vector<Row> keys);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  void set_content(Content content);
  void toggle_keys();
  void toggle_figures();

  /// Returns whether the event belongs to a panel. Such an event must not move the view.
  bool take(const window::Event& event);

  /// Draws into a framebuffer (its OpenGL name) of this size in pixels. Panels are drawn when they
  /// change, and copied otherwise. So they are opaque: blending takes as long as drawing in software.
  void draw(std::uint32_t framebuffer, int width, int height);

  /// Returns the switches that were clicked since the last call.
  std::vector<int> take_clicks() { return std::exchange(clicks_, {}); }

 private:
  struct Interface;  // Dear ImGui, and the panels that it has drawn.
  void draw_panels(int width, int height);

  gl::Context& context_;
  std::unique_ptr<Interface> interface_;
  std::vector<Row> keys_;
  Content content_;
  bool lists_keys_ = false;
  bool shows_figures_ = false;
  std::vector<int> clicks_;
};

}  // namespace copresence::overlay
