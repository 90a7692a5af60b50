#pragma once

// What each camera's receiver is doing: connected, waiting for its server, left out of the view, or at the
// end of its recording. The window's title and the log say what is awaited; a headless client ends when every
// camera has sent all it had. Any client ends when every camera is refused.
//
// Time comes in as an argument. Thread: any; receivers write, the render thread reads.

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "render_client/stream/availability.h"

namespace copresence::client {

class CameraStates {
 public:
  explicit CameraStates(
      std::size_t cameras, std::function<void()> on_all_refused = [] {})
      : cameras_(cameras), on_all_refused_(std::move(on_all_refused)) {}

  /// A try to connect has failed: `why` is a sentence that begins with the address. Returns what the log
  /// should say of it, which is nothing for most tries: the first is said, then one after 10 s, and later one
  /// a minute.
  std::optional<std::string> not_connected(std::size_t camera, std::string why, Instant now);

  void connected(std::size_t camera, std::string name);

  /// The server says what keeps its camera from sending frames; empty when nothing does any more.
  void notice(std::size_t camera, std::string text);

  /// The server has ended for good: its recording is over. `why` is its reason.
  void over(std::size_t camera, std::string why);

  /// Whether views show the camera, and why not, one sentence. When this makes every camera refused, calls
  /// `on_all_refused` once, from within.
  void availability(std::size_t camera, Availability availability, std::string reason);

  /// Nothing is to be waited for: every camera has ended for good or is left out, at least one has ended, and
  /// no server has come back since.
  bool all_over() const;

  /// Why views do without the camera; empty where they wait for it or show it.
  std::string left_out(std::size_t camera) const;
  /// What its server calls the camera; empty before the first connection.
  std::string name(std::size_t camera) const;

  /// Why there is nothing to show and the program ends; nothing until every camera was refused.
  std::optional<Error> all_refused() const;

  /// The window's title: `program`, and what is awaited of the first listed camera that is not there.
  std::string title(std::string_view program) const;

 private:
  struct Camera {
    bool is_connected = false;
    std::string name;    // of the camera, once connected
    std::string notice;  // why it sends nothing
    std::string over;    // why it has ended for good
    std::string why;     // it is not connected
    Availability availability = Availability::kAwaited;
    std::string left_out;  // why
    int tries = 0;         // that have failed since it was connected
    std::optional<Instant> next_said_at;
  };
  static std::string awaited(const Camera& camera);

  mutable std::mutex mutex_;
  std::vector<Camera> cameras_;
  const std::function<void()> on_all_refused_;
  std::optional<Error> all_refused_;
};

/// 1st, 2nd, 3rd, 4th, 11th, 21st.
std::string ordinal(int number);

}  // namespace copresence::client
