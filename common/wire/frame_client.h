#pragma once

// A connection to a capture_server: receives frames, sends acknowledgements and pings.
//
//   `kRefused`: connecting again is useless: the releases or the room keys differ, only one end has
//     a key, or the server gives a reason that this release does not know.
//   `kEndOfStream`: the server ended the stream; the text is its reason.
//   `kNotFound`: no server answers at this address.
//   `kUnavailable`: the server is full or closed the connection, or a stop was requested.
//   `kCorrupt`: the peer is not a capture_server, or its messages are damaged.
//   `kTimeout`: the server sent nothing for too long.
//
// After an error the connection is closed, unless receive() was stopped or reached `latest`.
// Connecting again may help after all errors except kRefused. Thread: one thread; any thread may
// call request_keyframe().

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/tls/room_key.h"
#include "common/wire/clock_offset.h"
#include "common/wire/message.h"

namespace copresence::wire {

struct ReceivedFrame {
  EncodedFrame frame;
  FrameCounters counters;
  Instant sent_at{};      ///< Server's clock; FrameClient::clock() converts it.
  Instant received_at{};  ///< Arrival of the last byte, on the client's clock.
};

class FrameClient {
 public:
  /// Connects and exchanges the first messages within `timeout`. The lookup of the host name comes
  /// first and has no time limit. A stop request returns kUnavailable at once. With a `key`, the
  /// connection is encrypted, and the server must prove that it has the same key.
  static Result<FrameClient> connect(const std::string& host_port, std::chrono::milliseconds timeout,
                                     std::stop_token stop, const tls::RoomKey* key = nullptr);
  FrameClient(FrameClient&&) noexcept;
  FrameClient& operator=(FrameClient&&) noexcept;
  ~FrameClient();

  const StreamDescription& description() const;

  /// Sets a callback for the status of the server's camera. receive() calls it with the reason why
  /// no frames come. Once the camera works again, the text is empty.
  void on_camera_status(std::function<void(const std::string&)> callback);

  /// Waits for the next frame and acknowledges it. Call this only when you can use another frame,
  /// since the acknowledgements bound the latency. A stop request returns kUnavailable. Returns
  /// kTimeout if no byte arrives for 5 s, or if no frame arrives until `latest`. In the second case
  /// the connection stays open.
  Result<ReceivedFrame> receive(std::stop_token stop, std::optional<Instant> latest = {});

  /// Requests a keyframe because the stream cannot be decoded. receive() sends the request.
  void request_keyframe();

  ClockOffset clock() const;  ///< Exactly 0 +- 0 if both ends use the same clock.
  std::uint64_t bytes_received() const;

 private:
  class Protocol;
  explicit FrameClient(std::unique_ptr<Protocol> protocol);
  std::unique_ptr<Protocol> protocol_;
};

}  // namespace copresence::wire
