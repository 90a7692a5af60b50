#pragma once

// Decides when the one encoder of a stream should encode a frame, and when a keyframe, for all clients
// together.
//
// A frame is wanted while one client in sync wants it. A keyframe costs every client bytes, so at most one a
// second is asked for. Clients that join get one as soon as that allows. Clients that fell behind, and
// clients that ask for one, share keyframes whose extra bytes are at most about a twentieth of the stream, so
// that a client on a slow path cannot cost the others more for ever. When nobody is in sync, nobody pays and
// they need not wait.
//
// Thread: a value; frame_server.cpp guards it by a mutex.

#include <cstddef>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/flow_control/client_window.h"

namespace copresence::wire {

class EncoderDemand {
 public:
  explicit EncoderDemand(Duration frame_period) : frame_period_(frame_period) {}

  /// What the clients want now. Call begin(), then add() for each client, whenever one of them changed.
  class Clients {
   public:
    void add(const ClientWindow& window);

   private:
    friend class EncoderDemand;
    Instant wants_until_ = Instant::min();
    bool in_sync_ = false, joins_ = false, fell_behind_ = false;
  };
  void update(const Clients& clients) { clients_ = clients; }
  /// A client cannot decode what it gets. Forgotten with the next keyframe.
  void request_keyframe() { requested_ = true; }

  /// A frame encoded now would reach somebody.
  bool wants_frame(Instant now) const;
  /// The next frame must be a keyframe. A true answer is the caller's promise to encode one.
  bool take_keyframe_request(Instant now);
  /// A frame of the stream was handed out.
  void sent(bool keyframe, std::size_t bytes, Instant now);

 private:
  bool may_ask_for_keyframe(Instant now) const;

  Duration frame_period_;
  Clients clients_;
  bool requested_ = false, promised_ = false;
  std::optional<Instant> keyframe_taken_at_;
  Instant next_for_slow_clients_ = Instant::min();
  double mean_bytes_ = 0;  // of frames that are no keyframes
};

}  // namespace copresence::wire
