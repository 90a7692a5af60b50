#pragma once

// An OpenGL 4.5 core context, headless or of a window. Constructors of GL objects take a context as
// proof that a context is current on this thread. Version 4.5 suffices, and Debian 12's software
// renderer has no later one. Thread: a context, and every object created with it, belongs to the
// thread that created the context. A thread has one context at a time.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/gl/name.h"
#include "common/result.h"

namespace copresence::window {
class Window;
}

namespace copresence::gl {

/// With Debug::kOn the driver checks every call and reports errors. Slower; meant for tests.
enum class Debug : bool { kOff, kOn };

/// Operations that will read what shaders wrote, for Context::barrier().
enum class Reader : unsigned {
  kFetch = 1,         ///< Texture fetches and samples.
  kImage = 2,         ///< Image loads and stores.
  kStorage = 4,       ///< Shader storage blocks.
  kCommand = 8,       ///< Indirect commands.
  kIndices = 16,      ///< Index buffers.
  kFramebuffer = 32,  ///< Drawing and blits.
  kHost = 64,         ///< Calls of read() and write() of buffers and textures.
};
constexpr Reader operator|(Reader a, Reader b) {
  return Reader(unsigned(a) | unsigned(b));
}

class Context {
 public:
  /// Creates a context without a window through EGL. Uses the first graphics card that supports
  /// OpenGL 4.5, else a software renderer. Fails with kUnavailable if neither works; the message
  /// says what to install.
  static Result<std::unique_ptr<Context>> headless(Debug debug = Debug::kOff);

  /// Wraps the context that is current on this thread, for example a window's. That context must
  /// outlive this object. Fails with kUnsupported if the context's version is below 4.5.
  static Result<std::unique_ptr<Context>> of_current(Debug debug);

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const std::string& renderer_name() const { return renderer_name_; }
  const std::string& version() const { return version_; }

  /// True if the CPU executes the shaders. The client's own CPU renderer is then several times
  /// faster.
  bool is_software() const;

  /// Makes earlier shader writes to images and storage blocks visible to later operations.
  void barrier(Reader readers);

  /// Sends all commands to the graphics card. The function finish() also waits until they are done.
  void flush();
  void finish();

  /// Returns the errors that the driver reported since the last call, oldest first, at most 32.
  /// With Debug::kOff the errors are codes without a description.
  std::vector<std::string> take_errors();

  /// If take_errors() has an error, fails with kUnavailable and a message that names `doing`.
  Result<void> check(std::string_view doing);

  /// True on the thread that created this context.
  bool is_on_its_thread() const { return std::this_thread::get_id() == thread_; }

 private:
  friend class window::Window;
  friend class Framebuffer;

  explicit Context(Debug debug);

  void* display_ = nullptr;      // An EGLDisplay; null for a window's context.
  void* egl_context_ = nullptr;  // An EGLContext.
  std::thread::id thread_ = std::this_thread::get_id();
  std::string renderer_name_;
  std::string version_;
  std::vector<std::string> errors_;
  Name<delete_vertex_array> vertex_array_;  // Has no attributes: shaders fetch vertices from textures.
};

/// True if the system has a graphics card. Check this before you create a context that would be
/// useless in software: creating one loads a compiler and takes 50 MB.
bool has_graphics_card();

/// True if GL_RENDERER has the name of a software renderer.
bool is_software_renderer(std::string_view renderer_name);

}  // namespace copresence::gl
