#pragma once

// Takes frames from the cameras' mailboxes and selects the frames of the next view. With --sync,
// they are of nearly the same instant (nearest_instants.h), so that a moving object has the same
// position in all of them. Thread: one thread at a time per object.

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "common/flow/mailboxes.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/pacing/nearest_instants.h"

namespace copresence::pacing {

class FrameSync {
 public:
  /// Without `sync`, every frame is selected at once. `passed_over` is called with the camera's
  /// index for every frame that no view will show.
  FrameSync(std::size_t cameras, bool sync, std::function<void(std::size_t)> passed_over)
      : sync_(sync), cameras_(cameras), passed_over_(std::move(passed_over)) {}

  void gather(flow::Mailboxes<client::CameraFrame>& mailboxes, Instant now);

  /// Returns the camera's frame for the next view if it differs from that of the last view. Its
  /// `arrived_at` is the time at which it was selected. Call it after each gather().
  std::optional<client::CameraFrame> take(std::size_t camera);

  /// Returns whether frames are waiting for frames of other cameras.
  bool has_waiting() const;

  /// Returns `deadline`, or an earlier time at which gather() must be called to show a frame.
  Instant wake_by(Instant deadline) const;

 private:
  struct Camera {
    std::deque<client::CameraFrame> fresh;  ///< Frames that are not yet selected, oldest first.
    std::deque<Instant> instants;           ///< Capture times of `fresh`.
    std::optional<Instant> on_view;         ///< Capture time of the frame selected last.
    std::optional<Instant> last_arrival;
    Instant fresh_since{};          ///< Arrival of the oldest unselected or dropped frame.
    std::deque<Duration> gaps;      ///< Times between the captures of the newest frames.
    std::optional<Instant> newest;  ///< Capture time of the newest frame.
    Duration announced{};           ///< The stream's nominal period.
    std::optional<client::CameraFrame> chosen;
  };

  void add(std::size_t index, client::CameraFrame received);
  void choose(Instant now);
  static Duration period(const Camera& camera);
  static bool delivers(const Camera& camera, Instant now);

  bool sync_;
  std::vector<Camera> cameras_;
  std::function<void(std::size_t)> passed_over_;
  std::optional<Instant> at_latest_;
};

}  // namespace copresence::pacing
