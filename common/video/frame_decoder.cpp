#include "common/video/frame_decoder.h"

#include <utility>

namespace copresence::video {

Result<FrameDecoder> FrameDecoder::open(const StreamDescription& stream) {
  bitstream::FrameChain chain(stream);
  auto depth = PictureDecoder::open(stream.codec.format, stream.model.width, stream.model.height);
  if (!depth) return fail(depth.error());
  if (!stream.has_color) return FrameDecoder(std::move(chain), std::move(*depth), std::nullopt);
  auto color = PictureDecoder::open(PixelFormat::kYuv420, stream.model.width, stream.model.height);
  if (!color) return fail(color.error());
  return FrameDecoder(std::move(chain), std::move(*depth), std::move(*color));
}

FrameDecoder::FrameDecoder(bitstream::FrameChain chain, PictureDecoder depth,
                           std::optional<PictureDecoder> color)
    : chain_(std::move(chain)), depth_(std::move(depth)), color_(std::move(color)) {}

Result<PlanarFrame> FrameDecoder::decode(const EncodedFrame& encoded) {
  auto frame = decode_checked(encoded);
  if (!frame) chain_.await_keyframe();
  return frame;
}

Result<PlanarFrame> FrameDecoder::decode_checked(const EncodedFrame& encoded) {
  auto frame = chain_.next(encoded);
  if (!frame) return frame;
  if (frame->depth.keyframe) {
    depth_.reset();
    if (color_) color_->reset();
  }
  if (frame->depth.residuals.empty()) {
    auto depth = depth_.decode(encoded.depth);
    if (!depth) return fail(depth.error());
    frame->depth.picture = std::move(*depth);
  } else {
    depth_.reset();  // the picture is blank
  }
  if (!encoded.color.empty()) {
    auto color = color_->decode(encoded.color);
    if (!color) return fail(color.error());
    frame->color = std::move(*color);
  }
  return frame;
}

}  // namespace copresence::video
