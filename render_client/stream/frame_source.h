#pragma once

// Where the encoded frames of one camera come from. Decoding does not depend on what is behind this
// interface.
//
// Thread: one thread; request_keyframe() may be called from any.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/wire/clock_offset.h"
#include "common/wire/frame_client.h"

namespace copresence::stream {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const StreamDescription& description() const = 0;

  /// Waits for the next frame. Call it again only when ready for one more: this bounds the latency.
  /// Fails with kUnavailable when asked to stop. Fails with kTimeout if no frame comes until
  /// `latest`; the source can still be used then. After any other failure the source is at its end.
  virtual Result<wire::ReceivedFrame> next(std::stop_token stop, std::optional<Instant> latest) = 0;

  /// Asks for a frame that can be decoded without the frames before it.
  virtual void request_keyframe() = 0;

  /// How far the clock of the frames' times is from this process's clock.
  virtual wire::ClockOffset clock() const = 0;

  /// Sets a function that is called from within next() with the camera's status: why no frames
  /// come, or an empty text once they can come again.
  virtual void on_status(std::function<void(const std::string&)> changed) = 0;
};

/// Frames of a capture_server over the network. Connects to HOST:PORT within `timeout`. Errors of this function and of the source: see
/// common/wire/frame_client.h.
Result<std::unique_ptr<FrameSource>> connect_live(const std::string& host_port,
                                                  std::chrono::milliseconds timeout,
                                                  const std::stop_token& stop);

}  // namespace copresence::stream
