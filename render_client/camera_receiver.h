#pragma once

// One camera's way into the client: connect, receive, decode, hand over; and connect again when the server is
// gone.
//
// Thread: run() on a thread of its own; everything it hands over goes through the board and the statistics.

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/flow/latest_of_each.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "common/wire/frame_client.h"
#include "render_client/camera_setup.h"
#include "render_client/camera_states.h"
#include "render_client/clipping.h"
#include "render_client/depth_smoothing.h"
#include "render_client/frame_decoding.h"
#include "render_client/statistics.h"
#include "render_client/temporal_filter.h"

namespace copresence::client {

/// A decoded frame as the renderer wants it.
struct Received {
  RgbdFrame frame;
  Instant captured_at;  ///< on this process's clock
  Instant arrived_at;   ///< when it was ready to be shown
  std::shared_ptr<const StreamDescription>
      stream;  ///< what it belongs to; changes when the server starts anew
  std::shared_ptr<const CameraSetup> setup;  ///< of this stream and the scene file
};

class CameraReceiver {
 public:
  /// `address` HOST:PORT; frames go to `board`'s `slot`, and what this does to that of `states`. `scene` may
  /// be null. Depth outside its clip box becomes holes.
  CameraReceiver(std::string address, std::size_t slot, const scene::Scene* scene,
                 flow::LatestOfEach<Received>& board, CameraStatistics& statistics, CameraStates& states);

  /// Until a stop is requested. Retries whatever may pass with a backoff of at most half a second; fails only
  /// with what is final, and names the server: a refusal, or a stream that this program cannot decode.
  Result<void> run(std::stop_token stop);

 private:
  /// An error that does not name the server by itself.
  Error named(const Error& error) const;
  Result<void> receive_from(wire::FrameClient& client, std::stop_token stop);
  /// What every frame of one connection shares.
  struct Stream {
    std::shared_ptr<const StreamDescription> description;
    std::shared_ptr<const CameraSetup> setup;
    std::optional<Clipper> clipper;
  };
  void hand_over(const wire::FrameClient& client, RgbdFrame frame, const Stream& stream);

  std::string address_;
  std::size_t slot_;
  const scene::Scene* scene_;
  flow::LatestOfEach<Received>& board_;
  CameraStatistics& statistics_;
  CameraStates& states_;
  TemporalFilter temporal_filter_;
  DepthSmoothing smoothing_;
};

}  // namespace copresence::client
