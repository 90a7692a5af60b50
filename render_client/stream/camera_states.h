#pragma once

// Keeps the state of each camera's connection: connected, waiting for its server, left out of the
// view, or at the end of its recording. The window, its title and the log report the state. A
// headless client ends when every camera has ended or is refused. A window stays open then.
// Thread: any. Receivers write, and the render thread reads.

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

namespace copresence::stream {

/// A camera as the user listed it.
struct ListedCamera {
  std::string address;  ///< HOST:PORT of its server.
  std::string name;     ///< Empty if the scene file does not give it.
};

class CameraStates {
 public:
  explicit CameraStates(
      const std::vector<ListedCamera>& cameras, std::function<void()> on_all_refused = [] {});

  /// Call it when a try to connect has failed. `why` is a sentence that begins with the address.
  /// Returns a line for the log after the first try, after 10 s, and then once a minute.
  std::optional<std::string> not_connected(std::size_t camera, std::string why, Instant now);

  void connected(std::size_t camera, std::string name);

  /// Sets the server's camera status: the reason why no frames come, or an empty text.
  void status(std::size_t camera, std::string text);

  /// Call it when the server has ended for good, because its recording is over.
  void over(std::size_t camera, std::string why);

  /// Sets whether views show the camera. `reason` explains in one sentence why they do not. Calls
  /// `on_all_refused` once, as soon as every camera is refused.
  void availability(std::size_t camera, Availability availability, std::string reason);

  /// Returns whether no more frames will come: at least one camera has ended, and every other
  /// camera has ended or is left out.
  bool all_over() const;

  /// Returns why views do not wait for the camera, or an empty text if they wait for it or show it.
  std::string left_out(std::size_t camera) const;
  /// Returns the camera's name. It may be empty before the first connection.
  std::string name(std::size_t camera) const;

  /// Returns why no camera can be shown, or nothing unless every camera is refused.
  std::optional<Error> all_refused() const;

  /// Returns in one sentence why the camera sends no frames, or an empty text if they come.
  std::string why_no_frames(std::size_t camera) const;

  /// Returns the camera's name and address, as in "left at 127.0.0.1:7001".
  std::string name_and_address(std::size_t camera) const;

  /// Returns the window's title. It has `program` and the state of the first camera without frames.
  std::string title(std::string_view program) const;

 private:
  struct Camera {
    std::string address;
    std::string name;
    bool is_connected = false;
    std::string status;  // The reason why the camera sends no frames.
    std::string over;    // The reason why the camera has ended for good.
    std::string why;     // The reason why the camera is not connected.
    Availability availability = Availability::kAwaited;
    std::string left_out;  // The reason why the camera is left out.
    int tries = 0;         // Number of failed tries since the last connection.
    std::optional<Instant> next_said_at;
  };
  static std::string name_and_address(const Camera& camera);
  static std::string why_no_frames(const Camera& camera);

  mutable std::mutex mutex_;
  std::vector<Camera> cameras_;
  const std::function<void()> on_all_refused_;
  std::optional<Error> all_refused_;
};

/// Returns the ordinal of a positive number: "first" to "tenth", then "11th", "12th" and so on.
std::string ordinal(int number);

}  // namespace copresence::stream
