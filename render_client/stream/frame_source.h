#pragma once

// The interface of a source of encoded frames of one camera. Thread: one thread at a time.
// request_keyframe() may be called from any thread.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/tls/room_key.h"
#include "common/wire/clock_offset.h"
#include "common/wire/frame_client.h"

namespace copresence::stream {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const StreamDescription& description() const = 0;

  /// Waits for the next frame. To limit latency, call it only when the frame can be processed at
  /// once. Fails with kUnavailable if a stop is requested. Fails with kTimeout if no frame comes
  /// before `latest`; the source remains usable. After any other failure, the source is at its end.
  virtual Result<wire::ReceivedFrame> next(std::stop_token stop, std::optional<Instant> latest) = 0;

  /// Asks for a frame that can be decoded without the frames before it.
  virtual void request_keyframe() = 0;

  /// Returns the offset of the server's clock from this process's clock.
  virtual wire::ClockOffset clock() const = 0;

  /// Sets a function that next() calls with the camera's status: the reason why no frames come, or
  /// an empty text once they can come again.
  virtual void on_status(std::function<void(const std::string&)> changed) = 0;
};

/// Connects to a capture_server at HOST:PORT within `timeout`, encrypted by `key` unless it is null.
/// This function and the source fail as common/wire/frame_client.h describes.
Result<std::unique_ptr<FrameSource>> connect_live(const std::string& host_port,
                                                  std::chrono::milliseconds timeout,
                                                  const std::stop_token& stop, const tls::RoomKey* key);

}  // namespace copresence::stream
