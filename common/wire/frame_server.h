#pragma once

// Sends one stream's frames to every client that has room for them. An encoded frame is not copied: all
// clients share it, and each gets its own 96 bytes in front. A slow client delays nobody and holds at most
// its window (client_window.h) of frames. A silent or dead client, or one that breaks the protocol, loses its
// connection and nothing else. Whom the server takes when many connect is decided by admission.h.
//
// Thread: run() on the wire thread; everything else on any thread at any time.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/wire/listening_socket.h"
#include "common/wire/message.h"

namespace copresence::wire {

struct ServerCounters {
  std::size_t clients = 0;           ///< now
  std::uint64_t bytes_sent = 0;      ///< to all clients since the start
  std::uint64_t frames_offered = 0;  ///< handed to send()
};

class FrameServer {
 public:
  /// A sentence for the server's log: who came and left, and what kept others from it. At most about two a
  /// second, whatever happens. Called on the wire thread.
  using LogLine = std::function<void(const std::string& sentence, bool is_warning)>;

  /// Serves the port with a descriptor of its own: the caller may keep the socket, or close it.
  /// Fails with kInvalid for a description that does not pass wire::check(), kUnavailable without file
  /// descriptors.
  static Result<std::unique_ptr<FrameServer>> open(const ListeningSocket& socket,
                                                   StreamDescription description, LogLine log_line = {});
  ~FrameServer();

  /// Accepts, sends and receives until asked to stop, or until end() is done. Calls `alive` four times a
  /// second. Call once.
  void run(std::stop_token stop, std::function<void()> alive = {});

  /// Hands a frame to every client that may have it; never blocks. Frames come in the order of their
  /// encoding. `counters`: of the whole stream; window_full counts frames that were not encoded since
  /// wants_frames() was false. Requires sequence and depth of at least one.
  void send(std::shared_ptr<const EncodedFrame> frame, const FrameCounters& counters);

  /// Whether a frame encoded now would reach anybody. False without clients: the encoder may rest.
  bool wants_frames() const;

  /// Whether the next frame must be a keyframe: somebody joined, has room again, or asked. True at most once
  /// a second; a true answer is a promise of the caller to encode one.
  bool take_keyframe_request();

  /// Sends all clients, and clients that join later, what keeps the camera from sending frames: one sentence,
  /// or an empty text once the camera works.
  void set_camera_status(std::string status);

  /// Tells all clients that nothing follows and why (one sentence); run() returns when they know, after at
  /// most 0.4 s. Frames sent before still go out first.
  void end(std::string reason);

  ServerCounters counters() const;

 private:
  class Loop;
  explicit FrameServer(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace copresence::wire
