#pragma once

// What the sensor gave, as a recording: every frame's depth bit by bit, every colour picture once, both with
// the sensor's own times. Before registration, range and hole filling, so that a replay goes the whole way
// again.
//
// The file is named as asked. Where a file of that name exists, the first free one of `name-2.oni`,
// `name-3.oni` and so on is created: a recording never overwrites a file, also when a crashed capture begins
// anew or when several servers begin at once.
//
// Thread: one thread at a time.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "capture_server/recording/oni_writer.h"
#include "capture_server/sensor/frame_source.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::server {

/// A recording's time from the sensor's: it never goes back. A sensor that begins to count anew (plugged in
/// again) goes on where it was, later by what passed meanwhile on this process's clock. Thread: a value.
class RecordingClock {
 public:
  /// The recording's zero minus the sensor's for this frame and those after it.
  std::chrono::microseconds offset_for(std::chrono::microseconds sensor_time, Instant captured_at);

 private:
  bool begun_ = false;
  std::chrono::microseconds offset_{}, last_{};
  Instant last_at_{};
};

class FrameRecording {
 public:
  /// `camera_name` goes into the camera's note. When the recording began by the clock (UTC) is noted with its first
  /// frame: a copy of a recording keeps the original's start, everything else began now.
  /// Fails (kUnavailable, kInvalid) where the file cannot be made.
  static Result<FrameRecording> open(const std::string& path, const sensor::SensorDescription& sensor,
                                     const std::string& camera_name);

  const std::string& path() const { return writer_.path(); }

  /// Fails  kInvalid, kUnsupported: this frame is left out; kUnavailable: no more can be written, finish().
  Result<void> write(const RgbdFrame& frame);

  /// What was written so far survives this process.
  Result<void> checkpoint() { return writer_.checkpoint(); }

  /// Call once, last. The file is then checked as a replay would check it, up to kMostChecked frames: longer ones take
  /// more time than a stop has.
  Result<void> finish();

  std::uint64_t frames() const { return frames_; }
  std::uint64_t bytes() const { return writer_.bytes(); }

  static constexpr std::uint64_t kMostChecked = 20'000;

 private:
  FrameRecording(recording::OniWriter writer, const sensor::SensorDescription& sensor)
      : writer_(std::move(writer)), has_color_(sensor.has_color), sensor_unix_zero_us_(sensor.unix_zero_us) {}

  Result<void> note_start(const RgbdFrame& first, std::chrono::microseconds offset);

  recording::OniWriter writer_;
  bool has_color_;
  std::optional<std::int64_t> sensor_unix_zero_us_;
  bool start_is_noted_ = false;
  RecordingClock clock_;
  std::chrono::microseconds last_color_{};
  std::uint64_t frames_ = 0;
};

}  // namespace copresence::server
