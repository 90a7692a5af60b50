#include "common/video/frame_encoder.h"

#include <cassert>
#include <chrono>
#include <utility>

#include "common/bitstream/side_data.h"

namespace copresence::video {

namespace {

/// Size of x264's buffer for colour: the bits of this many frames of mean size. A keyframe may have
/// that size, so sending it at the mean rate takes this many frame periods.
constexpr double kColorBufferFrames = 3;

PictureRate color_rate(int kbps, double frames_per_second) {
  return {double(kbps), kbps * kColorBufferFrames / frames_per_second};
}

std::optional<DepthRateController> make_rate_controller(const VideoSettings& settings,
                                                        double frames_per_second) {
  if (!settings.depth_kbps) return std::nullopt;
  return DepthRateController(*settings.depth_kbps, frames_per_second);
}

std::optional<PictureRate> first_rate(const std::optional<DepthRateController>& rate_controller) {
  if (!rate_controller) return std::nullopt;
  return rate_controller->picture_rate(0);
}

}  // namespace

Result<FrameEncoder> FrameEncoder::open(const StreamDescription& stream, const VideoSettings& settings) {
  if (auto checked = check(settings); !checked) return fail(checked.error());
  PictureSettings depth_settings{.kind = PictureKind::kDepth,
                                 .preset = settings.preset,
                                 .format = stream.codec.format,
                                 .width = stream.model.width,
                                 .height = stream.model.height,
                                 .frames_per_second = stream.frames_per_second,
                                 .qp = settings.depth_qp};
  const auto rate_controller = make_rate_controller(settings, stream.frames_per_second);
  depth_settings.rate = first_rate(rate_controller);
  auto depth = PictureEncoder::open(depth_settings);
  if (!depth) return fail(depth.error());
  if (!stream.has_color) return FrameEncoder(settings, std::move(*depth), rate_controller, std::nullopt);
  PictureSettings color_settings = depth_settings;
  color_settings.kind = PictureKind::kColor;
  color_settings.format = PixelFormat::kYuv420;
  color_settings.rate = color_rate(settings.color_kbps, stream.frames_per_second);
  auto color = PictureEncoder::open(color_settings);
  if (!color) return fail(color.error());
  return FrameEncoder(settings, std::move(*depth), rate_controller, std::move(*color));
}

FrameEncoder::FrameEncoder(const VideoSettings& settings, PictureEncoder depth,
                           std::optional<DepthRateController> rate_controller,
                           std::optional<PictureEncoder> color)
    : settings_(settings),
      depth_(std::move(depth)),
      rate_controller_(rate_controller),
      color_(std::move(color)) {}

void FrameEncoder::encode_color_ahead(std::uint64_t sequence, const Picture& color, bool keyframe) {
  assert(color_);
  color_keyframe_needed_ = color_keyframe_needed_ || keyframe;
  color_ahead_ = {sequence, color_keyframe_needed_, color_->encode(color, color_keyframe_needed_)};
}

Result<EncodedFrame> FrameEncoder::encode(const PlanarFrame& frame) {
  const bool keyframe = frame.depth.keyframe;
  assert(keyframe || previous_ != 0);
  assert(frame.metadata.sequence > previous_ && (!frame.color || color_));
  color_keyframe_needed_ = color_keyframe_needed_ || keyframe;
  const bool is_color_ready = color_ahead_ && color_ahead_->sequence == frame.metadata.sequence &&
                              color_ahead_->is_keyframe == color_keyframe_needed_;
  if (frame.color && !is_color_ready) {
    encode_color_ahead(frame.metadata.sequence, *frame.color, keyframe);
  }
  Result<AccessUnit> color = frame.color ? std::move(color_ahead_->color) : AccessUnit();
  color_ahead_.reset();

  bitstream::SideData data;
  data.sequence = frame.metadata.sequence;
  data.previous = keyframe ? 0 : previous_;
  data.captured_at = frame.metadata.captured_at;
  data.has_color = frame.color.has_value();
  if (keyframe || previous_pose_ != frame.metadata.world_from_camera)
    data.world_from_camera = frame.metadata.world_from_camera;
  data.table = frame.depth.table;
  data.residuals = frame.depth.residuals;
  data.validity_mask = frame.depth.validity_mask;

  if (rate_controller_) depth_.set_rate(rate_controller_->picture_rate(bitstream::side_data_bytes(data)));
  const auto depth = encode_depth(frame.depth);
  if (!depth) return fail(depth.error());
  if (!blank_) data.qp = static_cast<std::uint8_t>(depth_.qp());
  if (!color) return fail(color.error());
  if (frame.color) color_keyframe_needed_ = false;

  EncodedFrame encoded;
  encoded.keyframe = keyframe;
  encoded.sequence = frame.metadata.sequence;
  encoded.depth = bitstream::add_side_data(*depth, *color, data);
  encoded.color = std::move(*color);
  encoded.durations = frame.durations;
  if (rate_controller_) rate_controller_->spent(encoded.depth.size());
  previous_ = frame.metadata.sequence;
  previous_pose_ = frame.metadata.world_from_camera;
  return encoded;
}

Result<FrameEncoder::AccessUnit> FrameEncoder::encode_depth(const PlanarDepth& depth) {
  const bool exact = !depth.residuals.empty();
  assert(exact == blank_.has_value() || depth.keyframe);
  if (!exact) {
    blank_.reset();
    return depth_.encode(depth.picture, depth.keyframe);
  }
  const PictureSettings& settings = depth_.settings();
  if (!blank_) blank_.emplace(settings.format, settings.width, settings.height);
  return blank_->write(depth.keyframe);
}

Result<bool> FrameEncoder::change(const VideoSettings& settings) {
  assert(settings.preset == settings_.preset);
  if (auto checked = check(settings); !checked) return fail(checked.error());
  const double frames_per_second = depth_.settings().frames_per_second;
  const bool same_stream = rate_controller_ ? settings.depth_kbps.has_value()
                                            : !settings.depth_kbps && settings.depth_qp == settings_.depth_qp;
  if (!same_stream) {
    PictureSettings depth_settings = depth_.settings();
    const auto rate_controller = make_rate_controller(settings, frames_per_second);
    depth_settings.qp = settings.depth_qp;
    depth_settings.rate = first_rate(rate_controller);
    auto depth = PictureEncoder::open(depth_settings);
    if (!depth) return fail(depth.error());
    depth_ = std::move(*depth);
    rate_controller_ = rate_controller;
  } else if (rate_controller_) {
    rate_controller_->set_kbps(*settings.depth_kbps);
  }
  if (color_) color_->set_rate(color_rate(settings.color_kbps, frames_per_second));
  settings_ = settings;
  return !same_stream;
}

}  // namespace copresence::video
