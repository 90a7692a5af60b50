#include "common/window/window.h"

#include <epoxy/gl.h>
//
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <utility>

namespace copresence::window {
namespace {

constexpr GLuint kScreen = 0;  // The window's own framebuffer.

Key key_of(int key) {
  switch (key) {
    case GLFW_KEY_ESCAPE:
      return Key::kEscape;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      return Key::kEnter;
    case GLFW_KEY_TAB:
      return Key::kTab;
    case GLFW_KEY_BACKSPACE:
      return Key::kBackspace;
    case GLFW_KEY_RIGHT:
      return Key::kRight;
    case GLFW_KEY_LEFT:
      return Key::kLeft;
    case GLFW_KEY_DOWN:
      return Key::kDown;
    case GLFW_KEY_UP:
      return Key::kUp;
    case GLFW_KEY_PAGE_UP:
      return Key::kPageUp;
    case GLFW_KEY_PAGE_DOWN:
      return Key::kPageDown;
    case GLFW_KEY_HOME:
      return Key::kHome;
    case GLFW_KEY_END:
      return Key::kEnd;
    default:
      break;
  }
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return Key(int(Key::kF1) + key - GLFW_KEY_F1);
  return key >= ' ' && key <= '~' ? Key(key) : Key::kUnknown;
}

Modifiers modifiers_of(int bits) {
  return {.shift = (bits & GLFW_MOD_SHIFT) != 0,
          .control = (bits & GLFW_MOD_CONTROL) != 0,
          .alt = (bits & GLFW_MOD_ALT) != 0};
}

Result<GLFWwindow*> make_window(const std::string& title, int width, int height, gl::Debug debug) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug == gl::Debug::kOn);
  // Pixels without a surface are transparent in the view, but the window must be opaque.
  glfwWindowHint(GLFW_ALPHA_BITS, 0);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  // Some drivers support only EGL.
  for (const int api : {GLFW_NATIVE_CONTEXT_API, GLFW_EGL_CONTEXT_API}) {
    glfwWindowHint(GLFW_CONTEXT_CREATION_API, api);
    if (GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr)) return window;
  }
  return fail(ErrorCode::kUnsupported,
              "this display has no OpenGL 4.5 for a window: update its driver or use --headless");
}

}  // namespace

struct Window::Callbacks {
  static Window& of(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

  static void button(GLFWwindow* window, int button, int action, int bits) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    Window& self = of(window);
    double x = 0, y = 0;
    glfwGetCursorPos(window, &x, &y);
    self.events_.push_back(ButtonEvent{.button = Button(button),
                                       .pressed = action == GLFW_PRESS,
                                       .x = x * self.pixels_per_unit_,
                                       .y = y * self.pixels_per_unit_,
                                       .modifiers = modifiers_of(bits)});
  }

  static void move(GLFWwindow* window, double x, double y) {
    Window& self = of(window);
    const auto held = [&](int button) { return glfwGetMouseButton(window, button) == GLFW_PRESS; };
    self.events_.push_back(MoveEvent{.x = x * self.pixels_per_unit_,
                                     .y = y * self.pixels_per_unit_,
                                     .left = held(GLFW_MOUSE_BUTTON_LEFT),
                                     .right = held(GLFW_MOUSE_BUTTON_RIGHT),
                                     .middle = held(GLFW_MOUSE_BUTTON_MIDDLE),
                                     .modifiers = self.modifiers()});
  }

  static void scroll(GLFWwindow* window, double x, double y) {
    of(window).events_.push_back(ScrollEvent{x, y});
  }

  static void key(GLFWwindow* window, int key, int, int action, int bits) {
    of(window).events_.push_back(KeyEvent{.key = key_of(key),
                                          .pressed = action != GLFW_RELEASE,
                                          .repeated = action == GLFW_REPEAT,
                                          .modifiers = modifiers_of(bits)});
  }

  static void resize(GLFWwindow* window, int, int) {
    Window& self = of(window);
    self.follow_size();
    self.events_.push_back(ResizeEvent{self.width_, self.height_});
  }
};

Result<std::unique_ptr<Window>> Window::open(const std::string& title, int width, int height,
                                             gl::Debug debug) {
  assert(width > 0 && height > 0);
  // GLFW tries Wayland first, and libwayland prints its own error message if there is no display.
  const bool has_display = std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
  if (!has_display || !glfwInit()) {
    return fail(ErrorCode::kUnavailable, "no display: set DISPLAY or use --headless");
  }
  const auto made = make_window(title, width, height, debug);
  if (!made) {
    glfwTerminate();
    return fail(made.error());
  }
  std::unique_ptr<Window> window(new Window(*made));
  auto context = gl::Context::of_current(debug);
  if (!context) return fail(context.error());
  window->context_ = std::move(*context);
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  window->read_framebuffer_ = gl::Name<gl::delete_framebuffer>(id);
  window->set_vsync(true);
  // If the window system counts in units larger than pixels, the picture is larger than requested.
  if (window->pixels_per_unit_ != 1) {
    glfwSetWindowSize(*made, int(std::lround(width / window->pixels_per_unit_)),
                      int(std::lround(height / window->pixels_per_unit_)));
    window->follow_size();
  }
  return window;
}

Window::Window(GLFWwindow* window) : window_(window) {
  glfwMakeContextCurrent(window);
  glfwSetWindowUserPointer(window, this);
  glfwSetMouseButtonCallback(window, Callbacks::button);
  glfwSetCursorPosCallback(window, Callbacks::move);
  glfwSetScrollCallback(window, Callbacks::scroll);
  glfwSetKeyCallback(window, Callbacks::key);
  glfwSetFramebufferSizeCallback(window, Callbacks::resize);
  follow_size();
}

Window::~Window() {
  read_framebuffer_ = {};
  host_picture_.reset();
  context_.reset();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

Modifiers Window::modifiers() const {
  const auto held = [&](int left, int right) {
    return glfwGetKey(window_, left) == GLFW_PRESS || glfwGetKey(window_, right) == GLFW_PRESS;
  };
  return {.shift = held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT),
          .control = held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
          .alt = held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT)};
}

void Window::follow_size() {
  glfwGetFramebufferSize(window_, &width_, &height_);
  int units = 0, rows = 0;
  glfwGetWindowSize(window_, &units, &rows);
  if (units > 0 && width_ > 0) pixels_per_unit_ = double(width_) / units;
}

double Window::refresh_rate_hz() const {
  GLFWmonitor* monitor = glfwGetWindowMonitor(window_);
  if (!monitor) monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  return mode && mode->refreshRate > 0 ? mode->refreshRate : 60.0;
}

std::vector<Event> Window::poll(std::chrono::duration<double> timeout) {
  if (timeout.count() > 0) {
    glfwWaitEventsTimeout(timeout.count());
  } else {
    glfwPollEvents();
  }
  return std::exchange(events_, {});
}

bool Window::should_close() const {
  return glfwWindowShouldClose(window_) != 0;
}

void Window::request_close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

bool Window::is_fullscreen() const {
  return glfwGetWindowMonitor(window_) != nullptr;
}

void Window::set_fullscreen(bool fullscreen) {
  if (fullscreen == is_fullscreen()) return;
  if (!fullscreen) {
    glfwSetWindowMonitor(window_, nullptr, x_before_, y_before_, width_before_, height_before_,
                         GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  if (!mode) return;
  glfwGetWindowPos(window_, &x_before_, &y_before_);
  glfwGetWindowSize(window_, &width_before_, &height_before_);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::set_vsync(bool vsync) {
  vsync_ = vsync;
  glfwSwapInterval(vsync ? 1 : 0);
}

void Window::present(std::uint32_t texture, int width, int height) {
  assert(width > 0 && height > 0);
  shown_ = {texture, width, height};
  present_again();
}

void Window::present_again() {
  if (shown_.texture == 0 && !draw_overlay_) return;
  if (width_ > 0 && height_ > 0) {
    const std::array<float, 4> black = {0, 0, 0, 1};
    glClearNamedFramebufferfv(kScreen, GL_COLOR, 0, black.data());
    if (shown_.texture != 0) blit_picture();
    if (draw_overlay_) draw_overlay_(kScreen);
    glfwSwapBuffers(window_);
  }
  keep_pace();
}

void Window::blit_picture() {
  const double scale = std::min(double(width_) / shown_.width, double(height_) / shown_.height);
  const int width = int(std::lround(shown_.width * scale));
  const int height = int(std::lround(shown_.height * scale));
  const int left = (width_ - width) / 2;
  const int bottom = (height_ - height) / 2;
  glNamedFramebufferTexture(read_framebuffer_.id(), GL_COLOR_ATTACHMENT0, shown_.texture, 0);
  const bool is_scaled = width != shown_.width || height != shown_.height;
  // Row 0 of the screen is the bottom row.
  glBlitNamedFramebuffer(read_framebuffer_.id(), kScreen, 0, 0, shown_.width, shown_.height, left,
                         bottom + height, left + width, bottom, GL_COLOR_BUFFER_BIT,
                         is_scaled ? GL_LINEAR : GL_NEAREST);
}

void Window::keep_pace() {
  using Clock = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / refresh_rate_hz()));
  // A display that makes present() wait would have taken longer than this.
  if (vsync_ && Clock::now() - presented_at_ < period * 3 / 4) {
    std::this_thread::sleep_until(presented_at_ + period);
  }
  presented_at_ = Clock::now();
}

void Window::present(const Image<Rgba8>& image) {
  if (image.empty()) return;
  if (!host_picture_ || host_picture_->width() != image.width() ||
      host_picture_->height() != image.height()) {
    host_picture_ =
        std::make_unique<gl::Texture>(*context_, gl::Format::kRgba8, image.width(), image.height());
  }
  host_picture_->upload(image);
  present(*host_picture_);
}

}  // namespace copresence::window
