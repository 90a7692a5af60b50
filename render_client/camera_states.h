#pragma once

// What each camera's receiver is doing: connected, waiting for its server, or at the end of its recording.
// The window's title and the log say what is awaited; a headless client ends when every camera has sent all
// it had.
//
// Time comes in as an argument. Thread: any; receivers write, the render thread reads.

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::client {

class CameraStates {
 public:
  explicit CameraStates(std::size_t cameras) : cameras_(cameras) {}

  /// A try to connect has failed: `why` is a sentence that begins with the address. Returns what the log
  /// should say of it, which is nothing for most tries: the first is said, then one after 10 s, and later one
  /// a minute.
  std::optional<std::string> not_connected(std::size_t camera, std::string why, Instant now);

  void connected(std::size_t camera, std::string name);

  /// The server says what keeps its camera from sending frames; empty when nothing does any more.
  void notice(std::size_t camera, std::string text);

  /// The server has ended for good: its recording is over. `why` is its reason.
  void over(std::size_t camera, std::string why);

  /// Every camera has ended for good, and no server has come back since.
  bool all_over() const;

  /// The window's title: `program`, and what is awaited of the first listed camera that is not there.
  std::string title(std::string_view program) const;

 private:
  struct Camera {
    bool is_connected = false;
    std::string name;    // of the camera, once connected
    std::string notice;  // why it sends nothing
    std::string over;    // why it has ended for good
    std::string why;     // it is not connected
    int tries = 0;       // that have failed since it was connected
    std::optional<Instant> next_said_at;
  };
  static std::string awaited(const Camera& camera);

  mutable std::mutex mutex_;
  std::vector<Camera> cameras_;
};

/// 1st, 2nd, 3rd, 4th, 11th, 21st.
std::string ordinal(int number);

}  // namespace copresence::client
