#include "capture_server/source.h"

#include <fmt/format.h>

#include "capture_server/drivers/simulated/simulated_uri.h"
#include "capture_server/recording/oni_check.h"

namespace copresence {
namespace {

constexpr std::string_view kDevicePrefix = "openni:";

// A Kinect v1's nominal field of view, radians, for recordings that do not tell theirs.
constexpr recording::RecordedStream::FieldOfView kNominal{1.0144686, 0.7898090};

CameraModel camera_of(const recording::RecordedStream& stream,
                      const recording::RecordedStream::FieldOfView& field_of_view) {
  return camera_from_field_of_view(stream.width, stream.height, field_of_view.horizontal,
                                   field_of_view.vertical);
}

sensor::CheckedRecording describe(const std::string& path, const recording::RecordingSummary& summary) {
  using Kind = recording::RecordedStream::Kind;
  const recording::RecordedStream& depth = *summary.find(Kind::kDepth);
  const recording::RecordedStream* color = summary.find(Kind::kColor);
  sensor::CheckedRecording checked;
  checked.path = path;
  checked.period_us = recording::mean_period_us(depth);
  checked.duration_us = summary.duration.count();
  checked.last_depth_frame = depth.last_frame;

  sensor::SensorDescription& description = checked.description;
  description.name = path.substr(path.find_last_of('/') + 1);
  if (summary.camera_note && !summary.camera_note->name.empty()) description.name = summary.camera_note->name;
  description.is_recording = true;
  description.frames = depth.frames();
  description.unit = depth.unit;
  description.frames_per_second = 1e6 / checked.period_us;
  const auto& note = summary.camera_note;
  const auto field_of_view = depth.field_of_view.value_or(kNominal);
  description.depth = note ? note->model : camera_of(depth, field_of_view);
  if (note) description.world_from_camera = note->world_from_camera;
  // A colour stream without a single frame is none: OpenNI2 would wait for it.
  if (color && color->frames() > 0) {
    checked.last_color_frame = color->last_frame;
    description.has_color = true;
    const bool same_size = color->width == depth.width && color->height == depth.height;
    description.registered = same_size && (!note || note->registered);
    description.color = description.registered
                            ? description.depth
                            : camera_of(*color, color->field_of_view.value_or(field_of_view));
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
  return sensor::open_recording(describe(source, *summary), settings);
}

}  // namespace copresence
