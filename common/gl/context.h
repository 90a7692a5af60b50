#pragma once

// An OpenGL 4.5 core context, headless or a window's. Every GL object's constructor takes one, as a witness
// that a context is current on this thread. 4.5 and never 4.6: Debian 12's software rasteriser ends there.
//
// Thread: a context belongs to the thread that made it, and so does every object made with it. A thread has
// one context at a time.

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

/// Whether the driver checks and reports: slower, for tests.
enum class Debug : bool { kOff, kOn };

/// What will read what shaders have written, for Context::barrier().
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
  /// A context without a window, through EGL: of the first graphics card that has one, else in software.
  /// Fails  kUnavailable where there is neither; the sentence names the way out.
  static Result<std::unique_ptr<Context>> headless(Debug debug = Debug::kOff);

  /// The context that is current on this thread, which somebody else owns, a window say. It must outlive
  /// this.
  /// Fails  kUnsupported where it is older than OpenGL 4.5.
  static Result<std::unique_ptr<Context>> of_current(Debug debug);

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const std::string& renderer_name() const { return renderer_name_; }
  const std::string& version() const { return version_; }

  /// Whether the processor plays graphics card: our own C++ is then several times faster.
  bool is_software() const;

  /// What shaders wrote into images and storage blocks so far is seen by these from here on.
  void barrier(Reader readers);

  /// Sends everything off; finish() also waits until it is done.
  void flush();
  void finish();

  /// What the driver complained about since the last call, oldest first, at most 32. With Debug::kOff only
  /// the bare error code is known.
  std::vector<std::string> take_errors();

  /// The first of take_errors() as an Error: kUnavailable, "`doing`: the driver's words".
  Result<void> check(std::string_view doing);

  /// Whether the calling thread is the one that made this context.
  bool is_on_its_thread() const { return std::this_thread::get_id() == thread_; }

 private:
  friend class window::Window;
  friend class Framebuffer;

  explicit Context(Debug debug);

  void* display_ = nullptr;      // EGL's; null for a window's context
  void* egl_context_ = nullptr;  // EGL's
  std::thread::id thread_ = std::this_thread::get_id();
  std::string renderer_name_;
  std::string version_;
  std::vector<std::string> errors_;
  Name<delete_vertex_array> vertex_array_;  // without attributes: vertices are pulled from textures
};

/// Whether the system shows a graphics card at all. Asked before a context is made only to find that it is
/// software: that alone loads a compiler and 50 MB.
bool has_graphics_card();

/// Whether a renderer of this name (GL_RENDERER) is a program and no graphics card.
bool is_software_renderer(std::string_view renderer_name);

}  // namespace copresence::gl
