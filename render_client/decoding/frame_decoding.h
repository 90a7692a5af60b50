#pragma once

// The client's half of a frame's way up to the renderer, in one line: video decode, depth decode, colour.
// The server's half is capture_server/encoding/frame_encoding.h.
//
// Thread: one thread decodes one stream.

#include <chrono>
#include <optional>

#include "common/depth/depth_codec.h"
#include "common/frame/coded_frame.h"
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

  /// Fails on damage, and on frames that need an earlier one that was lost: ask for a keyframe then. The
  /// result lacks colour where the server sent none with this frame.
  Result<RgbdFrame> decode(const EncodedFrame& encoded, Durations& durations);

  /// The longest time for which a colour picture stands in for missing ones.
  static constexpr std::chrono::milliseconds kLongestRepeat{1000};

  /// For a viewer: gives a frame without colour the newest colour picture of the stream, so that the camera
  /// does not flash grey. Returns whether it did. Does nothing where the frame has colour, where the stream
  /// has had none yet, and where the newest is older than the frame by more than kLongestRepeat. `frame` is
  /// the last that decode() returned.
  bool repeat_color(RgbdFrame& frame) const;

 private:
  FrameDecoding(video::FrameDecoder video, depth::Decoder depth)
      : video_(std::move(video)), depth_(std::move(depth)) {}

  video::FrameDecoder video_;
  depth::Decoder depth_;
  std::optional<Picture> newest_color_;
  Instant newest_color_at_{};  // instant of its frame, on the server's clock
};

}  // namespace copresence::client
