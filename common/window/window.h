#pragma once

// A window with its OpenGL context: shows pictures and tells what the person does.
//
// Thread: the program's main thread, because window systems want it so; one window at a time.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
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
  /// Opens a window whose picture has this size where the display allows.
  /// Fails  kUnavailable "no display: ..." without one; kUnsupported where it has no OpenGL 4.5.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height,
                                              gl::Debug debug = gl::Debug::kOff);

  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Current on the main thread as long as the window is.
  gl::Context& context() { return *context_; }

  /// Size of the picture in pixels of the display; 0 while the window is an icon.
  int width() const { return width_; }
  int height() const { return height_; }

  /// How often the display shows a new picture; 60 where it doesn't say.
  double refresh_rate_hz() const;

  /// What happened since the last call, oldest first; waits up to `timeout` for something to happen.
  std::vector<Event> poll(std::chrono::duration<double> timeout = {});

  /// Whether the person wants to go (the window's close button), or request_close() was called.
  bool should_close() const;
  void request_close();

  void set_title(const std::string& title);
  void set_fullscreen(bool fullscreen);
  bool is_fullscreen() const;

  /// With vsync (the default) present() waits for the display, so that nothing tears; where the display does not make
  /// it wait (no driver for that, the window an icon) it sleeps, so that a loop around it runs at refresh_rate_hz() at
  /// most.
  void set_vsync(bool vsync);

  /// Shows a picture, scaled to the window with its sides' ratio kept, black around it. The first takes any
  /// RGBA8 texture of this context by its GL name (MergedView::texture), rows from the top.
  void present(std::uint32_t texture, int width, int height);
  void present(const gl::Texture& texture) { present(texture.id(), texture.width(), texture.height()); }
  void present(const Image<Rgba8>& image);

  /// Shows the last picture anew, for a resized window or the next refresh; nothing where there was none. Requires
  /// that the texture of present(texture) is still there.
  void present_again();

 private:
  struct Callbacks;
  friend struct Callbacks;

  explicit Window(GLFWwindow* window);
  Modifiers modifiers() const;
  void follow_size();
  void keep_pace();

  GLFWwindow* window_;
  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<gl::Texture> host_picture_;  // for present(Image)
  gl::Name<gl::delete_framebuffer> read_framebuffer_;  // what a picture is copied from
  struct Shown {
    std::uint32_t texture = 0;
    int width = 0, height = 0;
  } shown_;
  bool vsync_ = true;
  std::chrono::steady_clock::time_point presented_at_{};
  std::vector<Event> events_;
  int width_ = 0;
  int height_ = 0;
  double pixels_per_unit_ = 1;  // of the window system's coordinates
  int x_before_ = 0, y_before_ = 0, width_before_ = 0, height_before_ = 0;  // full screen
};

}  // namespace copresence::window
