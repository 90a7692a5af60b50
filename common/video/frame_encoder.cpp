#include "common/video/frame_encoder.h"

#include <cassert>
#include <chrono>
#include <utility>

#include "common/video/side_data.h"

namespace copresence::video {

Result<FrameEncoder> FrameEncoder::open(const StreamDescription& stream, const VideoSettings& settings) {
  if (auto checked = check(settings); !checked) return fail(checked.error());
  PictureSettings depth_settings{.kind = PictureKind::kDepth,
                                 .format = stream.codec.format,
                                 .width = stream.model.width,
                                 .height = stream.model.height,
                                 .frames_per_second = stream.frames_per_second,
                                 .kbps = settings.depth_kbps.value_or(0),
                                 .qp = settings.depth_qp};
  auto depth = PictureEncoder::open(depth_settings);
  if (!depth) return fail(depth.error());
  if (!stream.has_color) return FrameEncoder(std::move(*depth), std::nullopt);
  PictureSettings color_settings = depth_settings;
  color_settings.kind = PictureKind::kColor;
  color_settings.format = PixelFormat::kYuv420;
  color_settings.kbps = settings.color_kbps;
  auto color = PictureEncoder::open(color_settings);
  if (!color) return fail(color.error());
  return FrameEncoder(std::move(*depth), std::move(*color));
}

FrameEncoder::FrameEncoder(PictureEncoder depth, std::optional<PictureEncoder> color)
    : depth_(std::move(depth)), color_(std::move(color)) {}

Result<EncodedFrame> FrameEncoder::encode(const PlanarFrame& frame) {
  const bool keyframe = frame.depth.keyframe;
  assert(keyframe || previous_ != 0);
  assert(frame.stamp.sequence > previous_ && (!frame.color || color_));
  color_keyframe_needed_ = color_keyframe_needed_ || keyframe;

  auto depth = depth_.encode(frame.depth.picture, keyframe);
  if (!depth) return fail(depth.error());
  std::vector<std::uint8_t> color;
  if (frame.color) {
    auto encoded = color_->encode(*frame.color, color_keyframe_needed_);
    if (!encoded) return fail(encoded.error());
    color = std::move(*encoded);
    color_keyframe_needed_ = false;
  }

  SideData data;
  data.sequence = frame.stamp.sequence;
  data.previous = keyframe ? 0 : previous_;
  data.captured_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(frame.stamp.captured_at.time_since_epoch())
          .count();
  data.has_color = frame.color.has_value();
  if (keyframe || previous_pose_ != frame.stamp.world_from_camera)
    data.world_from_camera = frame.stamp.world_from_camera;
  data.table = frame.depth.table;
  data.state_mask = frame.depth.state_mask;

  EncodedFrame encoded;
  encoded.keyframe = keyframe;
  encoded.sequence = frame.stamp.sequence;
  encoded.depth = add_side_data(*depth, color, data);
  encoded.color = std::move(color);
  encoded.durations = frame.durations;
  previous_ = frame.stamp.sequence;
  previous_pose_ = frame.stamp.world_from_camera;
  return encoded;
}

void FrameEncoder::set_depth_kbps(int kbps) {
  depth_.set_kbps(kbps);
}

void FrameEncoder::set_color_kbps(int kbps) {
  if (color_) color_->set_kbps(kbps);
}

}  // namespace copresence::video
