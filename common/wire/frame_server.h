#pragma once

// Serves one stream of frames to all clients. Clients share the encoded frames without copies. Only
// the 96 bytes before each frame are separate for each client. A slow client delays no other client
// and holds at most its window of frames (flow_control/client_window.h). A client that is silent or
// violates the protocol is disconnected. If many clients connect, flow_control/admission.h decides
// which ones the server keeps. Thread: one thread calls run(); any thread may call the other
// functions.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/tls/room_key.h"
#include "common/wire/listening_socket.h"
#include "common/wire/message.h"

namespace copresence::wire {

struct ServerCounters {
  std::size_t clients = 0;           ///< Current number of clients.
  std::uint64_t bytes_sent = 0;      ///< Bytes sent to all clients since the start.
  std::uint64_t frames_offered = 0;  ///< Passed to send().
};

class FrameServer {
 public:
  /// Receives at most about two lines a second for the server's log: clients that joined and left,
  /// and failed connections. Called on the wire thread.
  using LogLine = std::function<void(const std::string& sentence, bool is_warning)>;

  /// Serves the port through a duplicate file descriptor, so the caller may keep or close the
  /// socket. With a `key`, all connections are encrypted, and only clients with the same key are
  /// admitted. Without it (null), nothing is encrypted. Fails with kInvalid if the description does
  /// not pass wire::check(). Fails with kUnavailable without free file descriptors, and with
  /// kUnsupported if the installed OpenSSL cannot encrypt.
  static Result<std::unique_ptr<FrameServer>> open(const ListeningSocket& socket,
                                                   StreamDescription description, const tls::RoomKey* key,
                                                   LogLine log_line = {});
  ~FrameServer();

  /// Serves clients until a stop request or end(). Calls `alive` four times a second. Call it once.
  void run(std::stop_token stop, std::function<void()> alive = {});

  /// Sends a frame to every client that can accept it. Never blocks. Call this in the order of
  /// encoding. `counters` count the whole stream: window_full counts frames that were not encoded
  /// because wants_frames() was false. Requires depth and a sequence number of at least 1.
  void send(std::shared_ptr<const EncodedFrame> frame, const FrameCounters& counters);

  /// True if a client would get a frame that is encoded now. Otherwise the encoder can pause.
  bool wants_frames() const;

  /// True if the next frame must be a keyframe: a client joined, fell behind, or requested one.
  /// Returns true at most once a second. The caller must then encode a keyframe.
  bool take_keyframe_request();

  /// Sends the status of the camera to all present and later clients. The status is one sentence
  /// with the reason why no frames come. The status is empty if the camera works.
  void set_camera_status(std::string status);

  /// Ends the stream after the frames that were sent. Every client gets `reason`, one sentence.
  /// When all clients have `reason`, or after 0.4 s, run() returns.
  void end(std::string reason);

  ServerCounters counters() const;

 private:
  class Loop;
  explicit FrameServer(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace copresence::wire
