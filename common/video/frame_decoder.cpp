#include "common/video/frame_decoder.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

namespace copresence::video {

Result<FrameDecoder> FrameDecoder::open(const StreamDescription& stream) {
  auto depth = PictureDecoder::open(stream.codec.format, stream.model.width, stream.model.height);
  if (!depth) return fail(depth.error());
  if (!stream.has_color) return FrameDecoder(std::move(*depth), std::nullopt, stream.world_from_camera);
  auto color = PictureDecoder::open(PixelFormat::kYuv420, stream.model.width, stream.model.height);
  if (!color) return fail(color.error());
  return FrameDecoder(std::move(*depth), std::move(*color), stream.world_from_camera);
}

FrameDecoder::FrameDecoder(PictureDecoder depth, std::optional<PictureDecoder> color,
                           Rigid3 world_from_camera)
    : depth_(std::move(depth)), color_(std::move(color)), world_from_camera_(std::move(world_from_camera)) {}

Result<PlanarFrame> FrameDecoder::decode(const EncodedFrame& encoded) {
  auto frame = decode_checked(encoded);
  if (frame) {
    previous_ = frame->metadata.sequence;
  } else {
    previous_.reset();
  }
  return frame;
}

Result<PlanarFrame> FrameDecoder::decode_checked(const EncodedFrame& encoded) {
  auto data = bitstream::extract_side_data(encoded.depth, encoded.color);
  if (!data) return fail(data.error());
  const bool keyframe = data->previous == 0;
  if (!keyframe && previous_ != data->previous) {
    return fail(
        ErrorCode::kCorrupt,
        previous_
            ? fmt::format("frame {} builds on frame {}, but the last one here is {}: a keyframe is needed",
                          data->sequence, data->previous, *previous_)
            : fmt::format("frame {} builds on frames that were lost: a keyframe is needed", data->sequence));
  }
  if (data->has_color && !color_)
    return fail(ErrorCode::kCorrupt, "a frame brings colour that its stream did not announce");
  if (keyframe) {
    depth_.reset();
    if (color_) color_->reset();
  }
  PlanarFrame frame;
  if (data->residuals.empty()) {
    auto depth = depth_.decode(encoded.depth);
    if (!depth) return fail(depth.error());
    frame.depth.picture = std::move(*depth);
  } else {
    depth_.reset();  // the picture is blank
  }
  if (data->has_color) {
    auto color = color_->decode(encoded.color);
    if (!color) return fail(color.error());
    frame.color = std::move(*color);
  }
  if (data->world_from_camera) world_from_camera_ = *data->world_from_camera;
  frame.metadata.sequence = data->sequence;
  frame.metadata.captured_at = data->captured_at;
  frame.metadata.world_from_camera = world_from_camera_;
  frame.depth.keyframe = keyframe;
  frame.depth.qp = data->qp;
  frame.depth.residuals = std::move(data->residuals);
  frame.depth.validity_mask = std::move(data->validity_mask);
  frame.depth.table = std::move(data->table);
  frame.durations = encoded.durations;
  return frame;
}

}  // namespace copresence::video
