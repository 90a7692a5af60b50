#pragma once

// Receives the frames of one camera over any number of connections, and reports them with every
// change of the connection. Thread: call run() on a thread of its own. `on_event` is called on that
// thread. Any thread may call request_keyframe().

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include "common/result.h"
#include "common/tls/room_key.h"
#include "common/wire/frame_client.h"
#include "common/wire/limited_log.h"
#include "web_gateway/forwarding/camera_event.h"

namespace copresence::gateway {

class CameraFeed {
 public:
  using OnEvent = std::function<void(forwarding::CameraEvent)>;

  /// `key` must outlive the feed. It is null if the server has no room key.
  CameraFeed(std::uint8_t index, std::string address, const tls::RoomKey* key, OnEvent on_event);

  /// Connects again and again until a stop is requested. Fails with kRefused if the server refuses
  /// this program for good.
  Result<void> run(const std::stop_token& stop);

  /// Asks the server for a keyframe. Does nothing without a connection.
  void request_keyframe();
  /// Call this after each FrameCame event has been processed. If too many are waiting, the feed
  /// drops frames until the next keyframe, so that memory stays bounded. Any thread may call it.
  void frame_taken() { --waiting_; }

 private:
  /// Receives until the connection ends, and returns the reason.
  Error receive(wire::FrameClient& client, const std::stop_token& stop);
  void pass_on(wire::ReceivedFrame received, wire::FrameClient& client);
  void report_failure(const Error& why, bool was_connected);

  std::uint8_t index_;
  std::string address_;
  const tls::RoomKey* key_;
  OnEvent on_event_;
  wire::LimitedLog log_;
  std::mutex mutex_;
  wire::FrameClient* client_ = nullptr;  // Guarded by mutex_; null without a connection.
  std::atomic<int> waiting_ = 0;         // Frames that were passed on and not taken.
  bool awaits_keyframe_ = false;         // True after a frame was dropped.
};

}  // namespace copresence::gateway
