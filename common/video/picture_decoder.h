#pragma once

// Decodes H.264 to pictures, the inverse of PictureEncoder. Each call decodes one access unit.
//
// The bytes may be untrusted: the result is an error, or a picture of the expected format and size.
// After an error only a keyframe is accepted, since other pictures depend on the failed picture.
// Thread: one thread at a time; different decoders are independent.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/picture.h"
#include "common/result.h"
#include "common/video/libav_owners.h"

namespace copresence::video {

class PictureDecoder {
 public:
  /// Fails with kUnsupported if libavcodec has no H.264 decoder.
  static Result<PictureDecoder> open(PixelFormat format, int width, int height);

  /// Fails with kCorrupt; then request a keyframe.
  Result<Picture> decode(std::span<const std::uint8_t> access_unit);

  /// Makes the decoder accept only a keyframe next, as at the beginning.
  void reset();

 private:
  PictureDecoder(PixelFormat format, int width, int height, CodecContext context, AvFrame frame,
                 AvPacket packet);
  Result<Picture> decode_checked(std::span<const std::uint8_t> access_unit);

  PixelFormat format_;
  int width_;
  int height_;
  CodecContext context_;
  AvFrame frame_;
  AvPacket packet_;
  std::vector<std::uint8_t> padded_;  // Essential NAL units, and padding for libavcodec.
  bool keyframe_needed_ = true;
};

}  // namespace copresence::video
