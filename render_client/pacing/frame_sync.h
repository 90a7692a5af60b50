#pragma once

// Takes frames from the cameras' mailboxes and decides which of them the next view shows. With
// --sync these are frames of nearly one instant (nearest_instants.h), so that all cameras show a
// moving object at one place.
//
// Thread: one at a time.

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
  /// Without `sync` every frame is passed on at once. `passed_over` is called with the camera's
  /// index for every frame that no view will show.
  FrameSync(std::size_t cameras, bool sync, std::function<void(std::size_t)> passed_over)
      : sync_(sync), cameras_(cameras), passed_over_(std::move(passed_over)) {}

  /// Takes the frames that have arrived.
  void gather(flow::Mailboxes<client::CameraFrame>& mailboxes, Instant now);

  /// The camera's frame for the next view, if it differs from that of the last view. Call it after
  /// each gather(). Its `arrived_at` is the time from which it may be shown.
  std::optional<client::CameraFrame> take(std::size_t camera);

  /// Whether frames are held back for frames of other cameras.
  bool has_waiting() const;

  /// The earlier of `deadline` and the time at which a waiting frame must be shown; call gather()
  /// then.
  Instant wake_by(Instant deadline) const;

 private:
  struct Camera {
    std::deque<client::CameraFrame> fresh;  ///< not yet shown, by rising instant
    std::deque<Instant> instants;           ///< of `fresh`
    std::optional<Instant> on_view;         ///< instant of the frame passed on last
    std::optional<Instant> last_arrival;
    Instant fresh_since{};          ///< arrival of the oldest frame not yet shown, also if it was dropped
    std::deque<Duration> gaps;      ///< between the instants of the newest frames
    std::optional<Instant> newest;  ///< instant of the newest frame
    Duration announced{};           ///< the stream's nominal period
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
