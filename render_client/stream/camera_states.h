#pragma once

// The state of each camera's connection: connected, waiting for its server, left out of the view,
// or at the end of its recording. The window's title and the log say what is awaited. A headless
// client ends when every camera has ended. Any client ends when every camera is refused.
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

namespace copresence::stream {

class CameraStates {
 public:
  explicit CameraStates(
      std::size_t cameras, std::function<void()> on_all_refused = [] {})
      : cameras_(cameras), on_all_refused_(std::move(on_all_refused)) {}

  /// A try to connect has failed. `why` is a sentence that begins with the address. Returns the
  /// line for the log: for the first try, then once after 10 s, then once a minute.
  std::optional<std::string> not_connected(std::size_t camera, std::string why, Instant now);

  void connected(std::size_t camera, std::string name);

  /// The server has sent the reason why its camera sends no frames. An empty text means that frames
  /// can come.
  void status(std::size_t camera, std::string text);

  /// The server has ended for good, because its recording is over. `why` is its reason.
  void over(std::size_t camera, std::string why);

  /// Sets whether views show the camera; `reason` is why not, as one sentence. If now every camera
  /// is refused, calls `on_all_refused` once, from within.
  void availability(std::size_t camera, Availability availability, std::string reason);

  /// Whether nothing more will come: every camera has ended or is left out, at least one has ended,
  /// and no server has come back since.
  bool all_over() const;

  /// Why views do without the camera. Empty if they wait for it or show it.
  std::string left_out(std::size_t camera) const;
  /// The camera's name. Empty before the first connection.
  std::string name(std::size_t camera) const;

  /// Why no camera can be shown, so that the program ends. Nothing until every camera is refused.
  std::optional<Error> all_refused() const;

  /// The window's title: `program`, and what the first listed camera that is not there waits for.
  std::string title(std::string_view program) const;

 private:
  struct Camera {
    bool is_connected = false;
    std::string name;    // of the camera, once connected
    std::string status;  // why it sends no frames
    std::string over;    // why it has ended for good
    std::string why;     // why it is not connected
    Availability availability = Availability::kAwaited;
    std::string left_out;  // why it is left out
    int tries = 0;         // failed tries since it was connected
    std::optional<Instant> next_said_at;
  };
  static std::string awaited(const Camera& camera);

  mutable std::mutex mutex_;
  std::vector<Camera> cameras_;
  const std::function<void()> on_all_refused_;
  std::optional<Error> all_refused_;
};

/// Returns 1st, 2nd, 3rd, 4th, 11th, 21st.
std::string ordinal(int number);

}  // namespace copresence::stream
