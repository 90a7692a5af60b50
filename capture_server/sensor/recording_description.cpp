#include "capture_server/sensor/recording_description.h"

namespace copresence::sensor {
namespace {

using recording::RecordedStream;

CameraModel camera_of(const RecordedStream& stream) {
  const auto& view = stream.field_of_view;
  return view ? camera_of_sensor(stream.width, stream.height, view->horizontal, view->vertical)
              : nominal_kinect(stream.width, stream.height);
}

// A colour stream without a field of view gets the field of view of depth.
CameraModel color_camera_of(const RecordedStream& color, const RecordedStream& depth) {
  if (color.field_of_view || !depth.field_of_view) return camera_of(color);
  return camera_of_sensor(color.width, color.height, depth.field_of_view->horizontal,
                          depth.field_of_view->vertical);
}

}  // namespace

RecordingDescription describe(const std::string& path, const recording::RecordingSummary& summary) {
  const RecordedStream& depth = *summary.find(RecordedStream::Kind::kDepth);
  const RecordedStream* color = summary.find(RecordedStream::Kind::kColor);
  const auto& metadata = summary.camera_metadata;
  RecordingDescription recording;
  recording.period_us = recording::usual_period_us(depth);
  recording.duration_us = summary.duration.count();
  recording.first_us = static_cast<std::int64_t>(depth.timestamps_us.front());
  if (summary.unix_zero_us && recording::steps_without_time(depth) == 0)
    recording.began_unix_us = *summary.unix_zero_us + recording.first_us;

  SensorDescription& sensor = recording.sensor;
  sensor.name =
      metadata && !metadata->name.empty() ? metadata->name : path.substr(path.find_last_of('/') + 1);
  sensor.is_recording = true;
  sensor.frames = depth.frames();
  sensor.unit = depth.unit;
  sensor.levels = depth.levels;
  sensor.frames_per_second = 1e6 / recording.period_us;
  sensor.depth = metadata ? metadata->model : camera_of(depth);
  sensor.unix_zero_us = summary.unix_zero_us;
  if (metadata) sensor.world_from_camera = metadata->world_from_camera;
  if (!color || color->frames() == 0) return recording;

  sensor.has_color = true;
  const bool same_size = color->width == depth.width && color->height == depth.height;
  sensor.registered = same_size && (!metadata || metadata->registered);
  sensor.color = sensor.registered ? sensor.depth : color_camera_of(*color, depth);
  if (!sensor.registered && metadata && metadata->color && metadata->color->model.width == color->width &&
      metadata->color->model.height == color->height) {
    sensor.color = metadata->color->model;
    sensor.color_from_depth = metadata->color->color_from_depth;
  }
  return recording;
}

}  // namespace copresence::sensor
