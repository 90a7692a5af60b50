#pragma once

// Between the cameras' mailboxes and the views: hands on what has arrived, with --sync only as frames of
// nearest instants (pacing/nearest_instants.h), so that what moves is in one place to all cameras.
//
// Thread: the render thread.

#include <deque>
#include <optional>
#include <vector>

#include "common/flow/mailboxes.h"
#include "render_client/pacing/nearest_instants.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_receiver.h"

namespace copresence::client {

class FrameSync {
 public:
  /// Without `sync` every frame is handed on as it comes.
  FrameSync(std::size_t cameras, bool sync) : sync_(sync), cameras_(cameras) {}

  /// Takes in what has arrived; frames that are passed over are counted as unshown.
  void gather(flow::Mailboxes<Received>& board, std::deque<CameraStatistics>& statistics, Instant now);

  /// The camera's frame that the next view is to show, where it is another than before; after each gather().
  /// Its arrived_at is the moment at which it may be shown.
  std::optional<Received> take(std::size_t camera);

  /// Whether frames are held back for those of other cameras.
  bool has_waiting() const;

  /// `deadline`, or earlier, where a frame must not wait as long: gather() again then.
  Instant wake_by(Instant deadline) const;

 private:
  struct Camera {
    std::deque<Received> fresh;      ///< by rising instant
    std::deque<Instant> instants;    ///< of these
    std::optional<Instant> on_view;  ///< instant of the frame handed on last
    std::optional<Instant> last_arrival;
    Instant fresh_since{};          ///< when the oldest of `fresh`, or one dropped for it, arrived
    std::deque<Duration> gaps;      ///< between the instants of the newest frames
    std::optional<Instant> newest;  ///< instant
    Duration announced{};           ///< period that the stream announces
    std::optional<Received> chosen;
  };

  void add(Camera& camera, Received received, CameraStatistics& statistics);
  void choose(std::deque<CameraStatistics>& statistics, Instant now);
  static Duration period(const Camera& camera);
  static bool delivers(const Camera& camera, Instant now);

  bool sync_;
  std::vector<Camera> cameras_;
  std::optional<Instant> at_latest_;
};

}  // namespace copresence::client
