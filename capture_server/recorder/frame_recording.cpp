#include "capture_server/recorder/frame_recording.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture_server/recording/oni_check.h"

namespace copresence::server {
namespace {

using std::chrono::microseconds;

constexpr microseconds kLatestTime{std::int64_t{1} << 55};  // Largest time in a recording.
constexpr microseconds kLongestPause{std::chrono::hours(24)};

}  // namespace

microseconds RecordingClock::offset_for(microseconds sensor_time, Instant captured_at) {
  const microseconds passed = std::chrono::duration_cast<microseconds>(captured_at - last_at_);
  const microseconds time = sensor_time + offset_;
  const bool sensible = begun_ ? time >= last_ && time - last_ < passed + kLongestPause
                               : time >= microseconds(0) && time < kLatestTime;
  if (!sensible)
    offset_ = (begun_ ? last_ + std::max(passed, microseconds(1)) : microseconds(0)) - sensor_time;
  begun_ = true;
  last_ = sensor_time + offset_;
  last_at_ = captured_at;
  return offset_;
}

Result<FrameRecording> FrameRecording::open(const std::string& path, const sensor::SensorDescription& sensor,
                                            const std::string& camera_name) {
  recording::OniContent content;
  content.camera = {camera_name, sensor.depth, sensor.registered, sensor.unit, sensor.world_from_camera,
                    std::nullopt};
  if (sensor.has_color && !sensor.registered) {
    content.camera.color = recording::ColorCameraMetadata{sensor.color, sensor.color_from_depth};
  }
  content.color = sensor.has_color ? std::optional(recording::ColorCoding::kJpeg) : std::nullopt;
  content.frames_per_second = std::clamp(static_cast<int>(std::lround(sensor.frames_per_second)), 1, 1000);
  content.max_depth = 65535;  // The sensor may report any depth.
  auto writer = recording::OniWriter::create_numbered(path, content);
  if (!writer) return fail(writer.error());
  return FrameRecording(std::move(*writer), sensor);
}

Result<void> FrameRecording::note_start(const RgbdFrame& first, microseconds offset) {
  if (std::exchange(start_is_noted_, true)) return {};
  if (sensor_unix_zero_us_) return writer_.note_unix_zero(*sensor_unix_zero_us_ - offset.count());
  const auto ago = std::chrono::steady_clock::now() - first.metadata.captured_at;
  const auto captured = std::chrono::system_clock::now().time_since_epoch() - ago;
  const auto zero = std::chrono::duration_cast<microseconds>(captured) - first.sensor_times.depth - offset;
  return writer_.note_unix_zero(zero.count());
}

Result<void> FrameRecording::finish() {
  auto finished = writer_.finish();
  if (!finished || frames_ == 0 || frames_ > kMostChecked) return finished;
  return recording::check_written(writer_.path());
}

Result<void> FrameRecording::write(const RgbdFrame& frame) {
  const SensorTimes& times = frame.sensor_times;
  const microseconds offset = clock_.offset_for(times.depth, frame.metadata.captured_at);
  if (auto noted = note_start(frame, offset); !noted) return noted;
  if (auto written = writer_.write_depth(times.depth + offset, frame.depth); !written) return written;
  ++frames_;
  if (!has_color_ || !frame.color || times.color_is_repeated) return {};
  // Colour from before a restart of the sensor's clock gets the previous colour picture's time.
  last_color_ = std::max(times.color + offset, last_color_);
  return writer_.write_color(last_color_, *frame.color);
}

}  // namespace copresence::server
