#pragma once

// One camera's way into the client: connect, receive, decode, hand over; and connect again when the server is
// gone.
//
// Thread: run() on a thread of its own; everything it hands over goes through the board, the states and the
// statistics.

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/flow/mailboxes.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "common/wire/frame_client.h"
#include "render_client/camera_setup.h"
#include "render_client/decoding/clipping.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/decoding/frame_decoding.h"
#include "render_client/decoding/temporal_filter.h"
#include "render_client/statistics/camera_states.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/availability.h"
#include "render_client/stream/limited_log.h"

namespace copresence::client {

/// A decoded frame as the renderer wants it.
struct Received {
  RgbdFrame frame;
  Instant captured_at;  ///< on this process's clock; the arrival where the server's times are not believed
  Instant arrived_at;   ///< when it was ready to be shown
  std::shared_ptr<const StreamDescription>
      stream;                                ///< what it belongs to; changes when the server starts anew
  std::shared_ptr<const CameraSetup> setup;  ///< of this stream and the scene file
  bool times_believed = true;  ///< `captured_at` is the server's, so the latency can be measured
};

class CameraReceiver {
 public:
  /// `address` HOST:PORT; frames go to `board`'s `slot`, and what this does to that of `states`. `scene` may
  /// be null. Depth outside its clip box becomes holes. All references must outlive this.
  CameraReceiver(std::string address, std::size_t slot, const scene::Scene* scene,
                 flow::Mailboxes<Received>& board, CameraStatistics& statistics, CameraStates& states);

  /// Until a stop is requested, or the server has refused this release for good. Everything else is retried
  /// with a pause of at most half a second. A camera that cannot be shown is said to be left out, in the log
  /// and in `states`.
  void run(std::stop_token stop);

 private:
  /// What every frame of one connection shares.
  struct Stream {
    std::shared_ptr<const StreamDescription> description;
    std::shared_ptr<const CameraSetup> setup;
    std::optional<Clipper> clipper;
  };

  /// An error that does not name the server by itself.
  Error named(const Error& error) const;
  /// Until the connection ends. Returns why.
  Error receive_from(wire::FrameClient& client, const std::stop_token& stop);
  void take(wire::FrameClient& client, FrameDecoding& decoding, const wire::ReceivedFrame& received,
            const Stream& stream);
  void hand_over(RgbdFrame frame, Instant captured_at, bool times_believed, const Stream& stream);
  void heard(const std::string& notice);
  /// Says it to all where the camera's availability has changed.
  void publish();
  void say_failure(const Error& why, bool was_connected);
  void say(LimitedLog::Topic topic, LimitedLog::Severity severity, std::string_view text);

  std::string address_;
  std::size_t slot_;
  const scene::Scene* scene_;
  flow::Mailboxes<Received>& board_;
  CameraStatistics& statistics_;
  CameraStates& states_;
  LimitedLog log_;
  AvailabilityTracker availability_;
  std::string camera_;  ///< its name, once a server has told it
  Availability published_ = Availability::kAwaited;
  std::string published_reason_;
  TemporalFilter temporal_filter_;
  DepthSmoothing smoothing_;
};

}  // namespace copresence::client
