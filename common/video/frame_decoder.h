#pragma once

// Decodes H.264 to frames; the inverse of FrameEncoder. Each call decodes one frame or fails.
//
// A frame is an error if it is damaged, cut or out of order, if a frame before it is missing, or if
// its two pictures are of different frames. Every frame after it is an error, too, until the next
// keyframe. So a wrong picture is never returned.
// Thread: one at a time; different decoders are independent.

#include <cstdint>
#include <optional>

#include "common/bitstream/side_data.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/video/picture_decoder.h"

namespace copresence::video {

class FrameDecoder {
 public:
  /// Fails with kUnsupported if libavcodec has no H.264 decoder.
  static Result<FrameDecoder> open(const StreamDescription& stream);

  /// Uses only the bytes of `depth` and `color`. Keyframe and sequence of the result are those
  /// inside the access unit. A frame may have no colour although the stream has it, if the camera
  /// had no colour for it.
  /// Fails with kCorrupt: request a keyframe then.
  Result<PlanarFrame> decode(const EncodedFrame& encoded);

 private:
  FrameDecoder(PictureDecoder depth, std::optional<PictureDecoder> color, Rigid3 world_from_camera);
  Result<PlanarFrame> decode_checked(const EncodedFrame& encoded);

  PictureDecoder depth_;
  std::optional<PictureDecoder> color_;
  Rigid3 world_from_camera_;
  std::optional<std::uint64_t>
      previous_;  // sequence of the last decoded frame; if absent, a keyframe is needed
};

}  // namespace copresence::video
