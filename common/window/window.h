#pragma once

// A window with an OpenGL context that shows pictures and returns the user's input. Only one window
// may exist at a time. Thread: the main thread, as window systems require.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/image.h"
#include "common/gl/context.h"
#include "common/gl/texture.h"
#include "common/result.h"
#include "common/window/event.h"

struct GLFWwindow;

namespace copresence::window {

class Window {
 public:
  /// Opens a window whose picture has this size, if the display allows it. Fails with kUnavailable
  /// without a display and with kUnsupported without OpenGL 4.5.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height,
                                              gl::Debug debug = gl::Debug::kOff);

  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// The window's context. The context is current on the main thread while the window exists.
  gl::Context& context() { return *context_; }

  /// Size of the picture in pixels of the display; 0 while the window is minimised.
  int width() const { return width_; }
  int height() const { return height_; }

  /// Refresh rate of the display; 60 if unknown.
  double refresh_rate_hz() const;

  /// Returns the events since the last call, oldest first. Waits up to `timeout` for an event.
  std::vector<Event> poll(std::chrono::duration<double> timeout = {});

  /// True after a click on the window's close button, or after request_close().
  bool should_close() const;
  void request_close();

  void set_title(const std::string& title);
  void set_fullscreen(bool fullscreen);
  bool is_fullscreen() const;

  /// With vsync (the default) present() waits for the display, which avoids tearing. If the display
  /// does not make present() wait, for instance while the window is minimised, the function sleeps.
  /// So a loop of present() runs at refresh_rate_hz() at most.
  void set_vsync(bool vsync);

  /// Shows a picture, scaled to the window with its aspect ratio kept and a black border. The first
  /// overload takes the GL name of an RGBA8 texture of this context, top row first.
  void present(std::uint32_t texture, int width, int height);
  void present(const gl::Texture& texture) { present(texture.id(), texture.width(), texture.height()); }
  void present(const Image<Rgba8>& image);

  /// Shows the last picture again, after a resize or for the next refresh. Requires that the texture
  /// of the last present() still exists. Without a last picture it shows black if there is an
  /// overlay, and does nothing otherwise.
  void present_again();

  /// Sets a function that draws over each picture before it is shown. Its argument is the OpenGL name
  /// of a framebuffer that has the size of the window's picture.
  void set_overlay(std::function<void(std::uint32_t framebuffer)> draw) { draw_overlay_ = std::move(draw); }

 private:
  struct Callbacks;
  friend struct Callbacks;

  explicit Window(GLFWwindow* window);
  Modifiers modifiers() const;
  void follow_size();
  void blit_picture();
  void keep_pace();

  GLFWwindow* window_;
  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<gl::Texture> host_picture_;          // Texture of present(Image).
  gl::Name<gl::delete_framebuffer> read_framebuffer_;  // Source of the blit.
  struct Shown {
    std::uint32_t texture = 0;
    int width = 0, height = 0;
  } shown_;
  std::function<void(std::uint32_t)> draw_overlay_;
  bool vsync_ = true;
  std::chrono::steady_clock::time_point presented_at_{};
  std::vector<Event> events_;
  int width_ = 0;
  int height_ = 0;
  double pixels_per_unit_ = 1;  // Pixels per unit of the window system.
  int x_before_ = 0, y_before_ = 0, width_before_ = 0,
      height_before_ = 0;  // Before full screen.
};

}  // namespace copresence::window
