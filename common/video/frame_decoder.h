#pragma once

// Decodes H.264 to frames; the inverse of FrameEncoder. Each call decodes one frame or fails.
//
// A call fails if the frame is damaged, cut or out of order, or if an earlier frame is missing. A
// call fails, too, if the two pictures belong to different frames. All later calls fail until the
// next keyframe, so a wrong picture is never returned. Thread: one thread at a time; different
// decoders are independent.

#include <optional>

#include "common/bitstream/frame_chain.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/video/picture_decoder.h"

namespace copresence::video {

class FrameDecoder {
 public:
  /// Fails with kUnsupported if libavcodec has no H.264 decoder.
  static Result<FrameDecoder> open(const StreamDescription& stream);

  /// Decodes the bytes `depth` and `color` and ignores the other members. Keyframe flag and
  /// sequence of the result come from the access unit. If the camera had no colour for a frame, the
  /// frame has none although the stream does. Fails with kCorrupt; then request a keyframe.
  Result<PlanarFrame> decode(const EncodedFrame& encoded);

 private:
  FrameDecoder(bitstream::FrameChain chain, PictureDecoder depth, std::optional<PictureDecoder> color);
  Result<PlanarFrame> decode_checked(const EncodedFrame& encoded);

  bitstream::FrameChain chain_;
  PictureDecoder depth_;
  std::optional<PictureDecoder> color_;
};

}  // namespace copresence::video
