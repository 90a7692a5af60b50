#include "capture_server/sensor/source.h"

#include <fmt/format.h>

#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/recording/oni_check.h"
#include "common/frame/camera_model.h"

namespace copresence {
namespace {

constexpr std::string_view kDevicePrefix = "openni:";

CameraModel camera_of(const recording::RecordedStream& stream) {
  const auto& view = stream.field_of_view;
  return view ? camera_of_sensor(stream.width, stream.height, view->horizontal, view->vertical)
              : nominal_kinect(stream.width, stream.height);
}

// Of a colour camera whose recording does not tell: that of depth, in its size.
CameraModel color_camera_of(const recording::RecordedStream& color, const recording::RecordedStream& depth) {
  if (color.field_of_view || !depth.field_of_view) return camera_of(color);
  return camera_of_sensor(color.width, color.height, depth.field_of_view->horizontal,
                          depth.field_of_view->vertical);
}

sensor::CheckedRecording describe(const std::string& path, const recording::RecordingSummary& summary) {
  using Kind = recording::RecordedStream::Kind;
  const recording::RecordedStream& depth = *summary.find(Kind::kDepth);
  const recording::RecordedStream* color = summary.find(Kind::kColor);
  sensor::CheckedRecording checked;
  checked.path = path;
  checked.period_us = recording::usual_period_us(depth);
  checked.duration_us = summary.duration.count();
  checked.last_depth_frame = depth.last_frame;
  checked.first_us = static_cast<std::int64_t>(depth.timestamps_us.front());
  if (summary.unix_zero_us && recording::steps_without_time(depth) == 0) {
    checked.began_unix_us = *summary.unix_zero_us + checked.first_us;
  }

  sensor::SensorDescription& description = checked.description;
  description.name = path.substr(path.find_last_of('/') + 1);
  if (summary.camera_note && !summary.camera_note->name.empty()) description.name = summary.camera_note->name;
  description.is_recording = true;
  description.frames = depth.frames();
  description.unit = depth.unit;
  description.frames_per_second = 1e6 / checked.period_us;
  const auto& note = summary.camera_note;
  description.depth = note ? note->model : camera_of(depth);
  description.unix_zero_us = summary.unix_zero_us;
  if (note) description.world_from_camera = note->world_from_camera;
  // A colour stream without a single frame is none: OpenNI2 would wait for it.
  if (color && color->frames() > 0) {
    checked.last_color_frame = color->last_frame;
    description.has_color = true;
    const bool same_size = color->width == depth.width && color->height == depth.height;
    description.registered = same_size && (!note || note->registered);
    description.color = description.registered ? description.depth : color_camera_of(*color, depth);
    if (!description.registered && note && note->color && note->color->model.width == color->width &&
        note->color->model.height == color->height) {
      description.color = note->color->model;
      description.color_from_depth = note->color->color_from_depth;
    }
  }
  return checked;
}

}  // namespace

bool is_recording(const std::string& source) {
  return !source.starts_with(kDevicePrefix) && !source.starts_with(drivers::kSimulatedPrefix);
}

Result<std::unique_ptr<sensor::FrameSource>> open_source(const std::string& source,
                                                         const sensor::SourceSettings& settings) {
  if (source.starts_with(drivers::kSimulatedPrefix)) {
    if (const auto uri = drivers::parse_simulated_uri(source); !uri) return fail(uri.error());
    return sensor::open_lasting_device(source, settings.controls);
  }
  if (!is_recording(source))
    return sensor::open_lasting_device(source.substr(kDevicePrefix.size()), settings.controls);
  const auto summary = recording::check(source);
  if (!summary) return fail(summary.error());
  const recording::RecordedStream& depth = *summary->find(recording::RecordedStream::Kind::kDepth);
  if (auto plays = recording::check_playable(depth, source); !plays) return fail(plays.error());
  return sensor::open_recording(describe(source, *summary), settings);
}

}  // namespace copresence
