#pragma once

// Decodes the frames of a stream: video, depth and colour. The server encodes them in
// capture_server/encoding/frame_encoding.h. Thread: one thread at a time per stream.

#include <chrono>
#include <optional>

#include "common/depth/depth_codec.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/video/frame_decoder.h"

namespace copresence::decoding {

class FrameDecoding {
 public:
  /// Fails if this program lacks the codec that the description names.
  static Result<FrameDecoding> open(const StreamDescription& description);

  struct Durations {
    Duration video_decode{}, depth_decode{};
  };

  /// Fails for a damaged frame and for a frame that depends on a lost frame. The caller should then
  /// request a keyframe. The result has no colour if the server sent no colour with this frame.
  Result<RgbdFrame> decode(const EncodedFrame& encoded, Durations& durations);

  static constexpr std::chrono::milliseconds kLongestRepeat{1000};

  /// Gives a frame without colour the newest colour picture of the stream, so that the view does
  /// not flash grey. Returns false if the frame has colour already, or if the picture is older than
  /// the frame by more than kLongestRepeat. `frame` must be the last result of decode().
  bool repeat_color(RgbdFrame& frame) const;

 private:
  FrameDecoding(video::FrameDecoder video, depth::Decoder depth)
      : video_(std::move(video)), depth_(std::move(depth)) {}

  video::FrameDecoder video_;
  depth::Decoder depth_;
  std::optional<Picture> newest_color_;
  Instant newest_color_at_{};  // Capture time on the server's clock.
};

}  // namespace copresence::decoding
