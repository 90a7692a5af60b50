#pragma once

// The client's half of a frame's way up to the renderer, in one line: video decode, depth decode, colour.
// The server's half is capture_server/frame_encoding.h.
//
// Thread: one thread decodes one stream.

#include "common/depth/depth_codec.h"
#include "common/frame/encoded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/video/frame_decoder.h"

namespace copresence::client {

class FrameDecoding {
 public:
  /// Fails where the description names a codec that this program does not have.
  static Result<FrameDecoding> open(const StreamDescription& description);

  struct Durations {
    Duration video_decode{}, depth_decode{};
  };

  /// Fails on damage, and on frames that need an earlier one that was lost: ask for a keyframe then.
  Result<RgbdFrame> decode(const EncodedFrame& encoded, Durations& durations);

 private:
  FrameDecoding(video::FrameDecoder video, depth::Decoder depth)
      : video_(std::move(video)), depth_(std::move(depth)) {}

  video::FrameDecoder video_;
  depth::Decoder depth_;
};

}  // namespace copresence::client
