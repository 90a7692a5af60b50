#include "render_client/decoding/frame_decoding.h"

#include "common/color/yuv420.h"

namespace copresence::decoding {

Result<FrameDecoding> FrameDecoding::open(const StreamDescription& description) {
  auto video = video::FrameDecoder::open(description);
  if (!video) return fail(video.error());
  auto depth =
      depth::Decoder::open(description.codec, {description.model.width, description.model.height,
                                               description.unit, description.range, description.noise});
  if (!depth) return fail(depth.error());
  return FrameDecoding(std::move(*video), std::move(*depth));
}

Result<RgbdFrame> FrameDecoding::decode(const EncodedFrame& encoded, Durations& durations) {
  const Instant begin = std::chrono::steady_clock::now();
  auto planar = video_.decode(encoded);
  if (!planar) return fail(planar.error());
  const Instant have_planes = std::chrono::steady_clock::now();
  durations.video_decode = have_planes - begin;

  RgbdFrame frame;
  frame.metadata = planar->metadata;
  frame.durations = encoded.durations;
  if (auto decoded = depth_.decode(planar->depth, frame.depth, frame.state); !decoded)
    return fail(decoded.error());
  if (planar->color) {
    newest_color_ = std::move(planar->color);
    newest_color_at_ = frame.metadata.captured_at;
    color::yuv420_to_rgb(*newest_color_, frame.color.emplace());
  }
  durations.depth_decode = std::chrono::steady_clock::now() - have_planes;
  return frame;
}

bool FrameDecoding::repeat_color(RgbdFrame& frame) const {
  if (frame.color || !newest_color_) return false;
  const Instant at = frame.metadata.captured_at;
  if (at < newest_color_at_ || at - newest_color_at_ > kLongestRepeat) return false;
  color::yuv420_to_rgb(*newest_color_, frame.color.emplace());
  return true;
}

}  // namespace copresence::decoding
