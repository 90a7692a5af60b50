#pragma once

// H.264 to frames: the inverse of FrameEncoder. One frame in, one out or an error, at once.
//
// A frame that is damaged, cut, missing, out of order, or whose two pictures don't belong together is an
// error, and so is every frame after it until a keyframe comes: a wrong picture is never handed out as a
// right one. Thread: one at a time; different decoders are independent.

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
  /// Fails with kUnsupported where libavcodec has no H.264 decoder.
  static Result<FrameDecoder> open(const StreamDescription& stream);

  /// Looks at the bytes of `depth` and `color` only: keyframe and sequence of the result come from inside the
  /// access unit. A frame may lack colour where the stream has it: the camera gave none, or it waits for its
  /// own keyframe. Fails with kCorrupt: ask for a keyframe.
  Result<PlanarFrame> decode(const EncodedFrame& encoded);

 private:
  FrameDecoder(PictureDecoder depth, std::optional<PictureDecoder> color, Rigid3 world_from_camera);
  Result<PlanarFrame> decode_checked(const EncodedFrame& encoded);

  PictureDecoder depth_;
  std::optional<PictureDecoder> color_;
  Rigid3 world_from_camera_;
  std::optional<std::uint64_t> previous_;  // sequence of the last good frame; nothing: a keyframe is needed
};

}  // namespace copresence::video
