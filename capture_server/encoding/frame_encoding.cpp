#include "capture_server/encoding/frame_encoding.h"

#include <fmt/format.h>

#include <utility>

#include "common/color/yuv420.h"

namespace copresence::server {
namespace {

/// Replaces the sensor's intrinsics and pose by those of the scene file.
sensor::SensorDescription apply_scene(sensor::SensorDescription sensor, const scene::Camera& camera) {
  sensor.depth = camera.model;
  if (camera.color) {
    sensor.color = camera.color->model;
    sensor.color_from_depth = camera.color->color_from_depth;
    sensor.registered = false;
  }
  if (camera.world_from_camera) sensor.world_from_camera = camera.world_from_camera;
  return sensor;
}

Result<void> check_scene_fits(const sensor::SensorDescription& sensor, const scene::Camera& camera) {
  if (camera.model.width == sensor.depth.width && camera.model.height == sensor.depth.height) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("the scene file says that camera \"{}\" gives {}x{} pixels, but it gives {}x{}",
                          camera.name, camera.model.width, camera.model.height, sensor.depth.width,
                          sensor.depth.height));
}

/// Returns true if frames are filtered over time. Lossless frames must stay as measured.
bool filters(temporal_filter::Mode mode, const EncoderSettings& settings) {
  return mode == temporal_filter::Mode::kAuto && !settings.is_lossless();
}

video::VideoSettings video_settings(const EncoderSettings& settings) {
  return {video::Preset::kLive, settings.depth_qp, settings.depth_kbps, settings.color_kbps};
}

}  // namespace

void clip_to_range(RgbdFrame& frame, const DepthRangeUnits& range) {
  const auto depth = frame.depth.pixels();
  const auto state = frame.state.pixels();
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const bool kept = range.contains(depth[i]);
    depth[i] = kept ? depth[i] : std::uint16_t{0};
    state[i] = kept ? state[i] : DepthState::kHole;
  }
}

Result<FrameEncoding> FrameEncoding::open(const sensor::SensorDescription& from_sensor,
                                          const scene::Camera* camera, const EncodingSettings& settings) {
  if (camera) {
    if (auto fits = check_scene_fits(from_sensor, *camera); !fits) return fail(fits.error());
  }
  const sensor::SensorDescription sensor = camera ? apply_scene(from_sensor, *camera) : from_sensor;

  auto registration = registration::Registration::open(
      {sensor.depth, sensor.has_color ? std::optional(sensor.color) : std::nullopt, sensor.color_from_depth,
       sensor.unit, sensor.registered, sensor.noise});
  if (!registration) return fail(registration.error());
  const CameraModel& model = registration->model();
  auto filler = hole_filling::open(settings.hole_filling, settings.compute,
                                   {model.width, model.height, sensor.unit, settings.range, sensor.noise});
  if (!filler) return fail(filler.error());
  auto depth = depth::Encoder::open(settings.codec,
                                    {model.width, model.height, sensor.unit, settings.range, sensor.noise});
  if (!depth) return fail(depth.error());
  depth->set_sensor_levels(sensor.levels);  // Registration does not change depth.
  depth->set_lossless(settings.encoder.is_lossless());
  depth->set_bitrate(settings.encoder.depth_kbps, sensor.frames_per_second);

  StreamDescription stream;
  stream.camera = settings.name;
  stream.model = model;
  stream.unit = sensor.unit;
  stream.range = settings.range;
  stream.noise = sensor.noise;
  stream.frames_per_second = sensor.frames_per_second;
  stream.has_color = sensor.has_color;
  stream.has_pose = sensor.world_from_camera.has_value();
  stream.world_from_camera = sensor.world_from_camera.value_or(Rigid3{});
  stream.codec = depth->description();

  stream.is_temporally_filtered = filters(settings.temporal_filter, settings.encoder);

  auto video = video::FrameEncoder::open(stream, video_settings(settings.encoder));
  if (!video) return fail(video.error());
  FrameEncoding encoding(std::move(stream), std::move(*registration), std::move(*filler), std::move(*depth),
                         std::move(*video), settings.temporal_filter);
  encoding.choose_filters(settings.encoder);
  return encoding;
}

FrameEncoding::FrameEncoding(StreamDescription description, registration::Registration registration,
                             std::unique_ptr<hole_filling::HoleFiller> filler, depth::Encoder depth,
                             video::FrameEncoder video, temporal_filter::Mode temporal_filter)
    : description_(std::move(description)),
      registration_(std::move(registration)),
      filler_(std::move(filler)),
      temporal_filter_(temporal_filter),
      depth_(std::move(depth)),
      video_(std::move(video)) {}

void FrameEncoding::choose_filters(const EncoderSettings& settings) {
  if (!filters(temporal_filter_, settings)) {
    filters_.reset();
  } else if (!filters_) {
    const CameraModel& model = description_.model;
    filters_.emplace(
        temporal_filter::DepthFilter(model.width, model.height, description_.unit, description_.noise),
        temporal_filter::ColorFilter());
  }
}

Result<void> FrameEncoding::change_settings(const EncoderSettings& settings) {
  const auto other_stream = video_.change(video_settings(settings));
  if (!other_stream) return fail(other_stream.error());
  depth_.set_lossless(settings.is_lossless());
  depth_.set_bitrate(settings.depth_kbps, description_.frames_per_second);
  choose_filters(settings);
  keyframe_due_ = keyframe_due_ || *other_stream;
  return {};
}

Result<EncodedFrame> FrameEncoding::encode(RgbdFrame frame, bool keyframe, Executor* workers) {
  using std::chrono::steady_clock;
  keyframe = std::exchange(keyframe_due_, false) || keyframe;
  frame.metadata.world_from_camera = description_.world_from_camera;
  const Instant begin = steady_clock::now();
  frame = registration_.apply(std::move(frame));
  clip_to_range(frame, to_units(description_.range, description_.unit));

  Instant filled, planes;
  Result<void> filling;
  Result<PlanarDepth> depth;
  const auto fill = [&] {
    filling = filler_->fill(frame);
    if (filling && filters_) filters_->depth.apply(frame.depth, frame.state);
    filled = steady_clock::now();
  };
  // This is the state after the last frame, since depth and colour are filtered at the same time.
  const bool camera_moves = filters_ && filters_->depth.is_camera_moving();
  const bool fills_here = !filler_->is_free_of_threads();
  if (fills_here) fill();
  PlanarFrame planar{frame.metadata, {}, std::nullopt, frame.durations};
  const auto half = [&](int number, int) {
    if (number == 0) {
      if (!fills_here) fill();
      if (!filling) return;
      depth = depth_.encode(frame.depth, frame.state, keyframe);
      planes = steady_clock::now();
    } else {
      color::rgb_to_yuv420(*frame.color, planar.color.emplace());
      if (filters_) filters_->color.apply(*planar.color, camera_moves);
      video_.encode_color_ahead(planar.metadata.sequence, *planar.color, keyframe);
    }
  };
  InlineExecutor alone;
  (workers ? *workers : alone).run(frame.color ? 2 : 1, half);
  if (!filling) return fail(filling.error());
  if (!depth) return fail(depth.error());
  planar.depth = std::move(*depth);

  auto encoded = video_.encode(planar);
  if (!encoded) return fail(encoded.error());
  encoded->durations.fill = filled - begin;
  encoded->durations.depth_encode = planes - filled;
  encoded->durations.video_encode = steady_clock::now() - planes;
  return encoded;
}

}  // namespace copresence::server
