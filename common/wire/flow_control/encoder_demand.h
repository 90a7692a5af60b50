#pragma once

// Decides for all clients together when the encoder of a stream encodes a frame or a keyframe.
//
// A frame is encoded if a client in sync requests it. A keyframe costs every client bytes, so at
// most one a second is requested. Within this limit, joining clients get a keyframe as soon as
// possible. Clients that fell behind, or that request a keyframe, get shared keyframes. Shared
// keyframes may add about a twentieth to the bytes of the stream. So a client on a slow path cannot
// cost the others more than that. If no client is in sync, a keyframe costs no other client, and
// the limit of a twentieth does not apply. Thread: one thread at a time; frame_server.cpp guards
// the object by a mutex.

#include <cstddef>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/flow_control/client_window.h"

namespace copresence::wire {

class EncoderDemand {
 public:
  explicit EncoderDemand(Duration frame_period) : frame_period_(frame_period) {}

  /// The combined demand of all clients at one time.
  class Clients {
   public:
    void add(const ClientWindow& window);

   private:
    friend class EncoderDemand;
    Instant wants_until_ = Instant::min();
    bool in_sync_ = false, joins_ = false, fell_behind_ = false;
  };
  /// Call this after a client's window has changed.
  void update(const Clients& clients) { clients_ = clients; }
  /// Reports that a client cannot decode the stream. The request holds until the next keyframe.
  void request_keyframe() { requested_ = true; }

  /// True if a client would get a frame that is encoded now.
  bool wants_frame(Instant now) const;
  /// True if the next frame must be a keyframe. The caller must then encode one.
  bool take_keyframe_request(Instant now);
  /// Reports that a frame of the stream was passed to the clients.
  void sent(bool keyframe, std::size_t bytes, Instant now);

 private:
  bool may_request_keyframe(Instant now) const;

  Duration frame_period_;
  Clients clients_;
  bool requested_ = false, promised_ = false;
  std::optional<Instant> keyframe_taken_at_;
  Instant next_for_slow_clients_ = Instant::min();
  double mean_bytes_ = 0;  // Mean size of frames that are not keyframes.
};

}  // namespace copresence::wire
