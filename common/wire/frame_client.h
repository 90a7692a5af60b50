#pragma once

// One connection to a capture_server: frames in, acknowledgements and pings out.
//
// Errors  kRefused is final: the releases differ. kEndOfStream carries the server's own words. All others
//         may pass: connect anew after a while. kNotFound: nobody answers there. kUnavailable: somebody does,
//         but is full or hung up. kCorrupt: it is no capture_server, or damaged. kTimeout: it fell silent.
//         After any of them the connection is over, but for receive() that was stopped or too late.
// Thread  one thread; request_keyframe() may be called from any.

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
#include "common/wire/clock_offset.h"
#include "common/wire/message.h"

namespace copresence::wire {

struct ReceivedFrame {
  EncodedFrame frame;
  FrameCounters counters;
  Instant sent_at{};      ///< server's clock; FrameClient::clock() maps it
  Instant received_at{};  ///< this process's clock: when the last byte arrived, however late it was read
};

class FrameClient {
 public:
  /// Connects and shakes hands within `timeout`. Looking a host's name up comes before that and takes as long
  /// as the system's resolver does. Returns kUnavailable at once when asked to stop.
  static Result<FrameClient> connect(const std::string& host_port, std::chrono::milliseconds timeout,
                                     std::stop_token stop);
  FrameClient(FrameClient&&) noexcept;
  FrameClient& operator=(FrameClient&&) noexcept;
  ~FrameClient();

  const StreamDescription& description() const;

  /// receive() will call `callback` when the server reports what keeps its camera from sending frames, and
  /// with an empty text once the camera works.
  void on_camera_status(std::function<void(const std::string&)> callback);

  /// Waits for the next frame and acknowledges it: call again when ready for one more, that is what keeps the
  /// latency bounded. Returns kUnavailable when asked to stop, and kTimeout when no byte has come for 5 s.
  /// Returns kTimeout, too, when no frame has come until `latest`; the connection then goes on.
  Result<ReceivedFrame> receive(std::stop_token stop, std::optional<Instant> latest = {});

  /// What comes cannot be decoded: asks for a keyframe. Sent at once, or from within the next receive().
  void request_keyframe();

  ClockOffset clock() const;  ///< exactly 0 +- 0 where both ends read the same clock
  std::uint64_t bytes_received() const;

 private:
  class Protocol;
  explicit FrameClient(std::unique_ptr<Protocol> protocol);
  std::unique_ptr<Protocol> protocol_;
};

}  // namespace copresence::wire
