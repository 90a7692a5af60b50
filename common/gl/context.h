#pragma once

// An OpenGL 4.5 core context, headless or of a window. The constructor of every GL object takes a
// context, to prove that one is current on this thread. The version is not 4.6, since Debian 12's
// software renderer has only 4.5.
//
// Thread: a context belongs to the thread that created it, and so does every object created with
// it. A thread has one context at a time.

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

/// Debug::kOn makes the driver check every call and report errors. It is slower and meant for
/// tests.
enum class Debug : bool { kOff, kOn };

/// The operations that will read what shaders wrote, for Context::barrier().
enum class Reader : unsigned {
  kFetch = 1,         ///< texture fetches and samples
  kImage = 2,         ///< image loads and stores
  kStorage = 4,       ///< shader storage blocks
  kCommand = 8,       ///< indirect commands
  kIndices = 16,      ///< index buffers
  kFramebuffer = 32,  ///< drawing and blits
  kHost = 64,         ///< read() and write() of buffers and textures
};
constexpr Reader operator|(Reader a, Reader b) {
  return Reader(unsigned(a) | unsigned(b));
}

class Context {
 public:
  /// Creates a context without a window through EGL, on the first graphics card that supports it,
  /// else in software. Fails with kUnavailable if neither works; the message says what to install.
  static Result<std::unique_ptr<Context>> headless(Debug debug = Debug::kOff);

  /// Wraps the context that is current on this thread and that a window owns, for instance. That
  /// context must outlive this object. Fails with kUnsupported if its version is below 4.5.
  static Result<std::unique_ptr<Context>> of_current(Debug debug);

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const std::string& renderer_name() const { return renderer_name_; }
  const std::string& version() const { return version_; }

  /// True if the CPU executes the shaders. The CPU renderer is then several times faster.
  bool is_software() const;

  /// Makes what shaders wrote into images and storage blocks visible to later operations of these
  /// kinds.
  void barrier(Reader readers);

  /// flush() sends all commands to the graphics card. finish() also waits until they are done.
  void flush();
  void finish();

  /// The errors that the driver reported since the last call, oldest first, at most 32. With
  /// Debug::kOff they are error codes without a description.
  std::vector<std::string> take_errors();

  /// Fails with kUnavailable and "`doing`: MESSAGE" if take_errors() has an error.
  Result<void> check(std::string_view doing);

  /// True on the thread that created this context.
  bool is_on_its_thread() const { return std::this_thread::get_id() == thread_; }

 private:
  friend class window::Window;
  friend class Framebuffer;

  explicit Context(Debug debug);

  void* display_ = nullptr;      // of EGL; null for a window's context
  void* egl_context_ = nullptr;  // of EGL
  std::thread::id thread_ = std::this_thread::get_id();
  std::string renderer_name_;
  std::string version_;
  std::vector<std::string> errors_;
  Name<delete_vertex_array> vertex_array_;  // without attributes: shaders fetch vertices from textures
};

/// True if the system has a graphics card. Check it before you create a context that would be of no
/// use in software: creating it loads a compiler and takes 50 MB.
bool has_graphics_card();

/// True if GL_RENDERER has the name of a software renderer.
bool is_software_renderer(std::string_view renderer_name);

}  // namespace copresence::gl
