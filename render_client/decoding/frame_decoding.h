#pragma once

// Decodes a frame: video, depth and colour. The server's counterpart is
// capture_server/encoding/frame_encoding.h.
//
// Thread: one thread decodes one stream.

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
  /// Fails if this program does not have the codec that the description names.
  static Result<FrameDecoding> open(const StreamDescription& description);

  struct Durations {
    Duration video_decode{}, depth_decode{};
  };

  /// Fails for damaged frames, and for frames that depend on a lost one: request a keyframe then.
  /// The result has no colour if the server sent none with this frame.
  Result<RgbdFrame> decode(const EncodedFrame& encoded, Durations& durations);

  /// The longest time for which an old colour picture is repeated.
  static constexpr std::chrono::milliseconds kLongestRepeat{1000};

  /// Gives a frame without colour the newest colour picture of the stream, so that the camera does
  /// not flash grey. Returns whether it did. A picture older than the frame by more than
  /// kLongestRepeat is not used. `frame` must be the last result of decode().
  bool repeat_color(RgbdFrame& frame) const;

 private:
  FrameDecoding(video::FrameDecoder video, depth::Decoder depth)
      : video_(std::move(video)), depth_(std::move(depth)) {}

  video::FrameDecoder video_;
  depth::Decoder depth_;
  std::optional<Picture> newest_color_;
  Instant newest_color_at_{};  // capture time of its frame, on the server's clock
};

}  // namespace copresence::decoding
