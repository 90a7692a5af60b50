#pragma once

// Records the sensor's frames with the sensor's own times: each depth picture without loss, each
// colour picture once. Frames are recorded before registration, range and hole filling, so that a
// replay runs these stages again.
//
// A recording never overwrites a file. If the requested file exists, the first free name of
// `name-2.oni`, `name-3.oni` and so on is used. No recording is overwritten after a crash or when
// several servers start at once.
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

/// Converts the sensor's times into a recording's times, which never decrease. The sensor's clock
/// restarts if the camera is plugged in again. The recording then continues at its last time plus
/// the time that has passed on this process's clock.
class RecordingClock {
 public:
  /// Offset from the sensor's times to the recording's, for this frame and later frames.
  std::chrono::microseconds offset_for(std::chrono::microseconds sensor_time, Instant captured_at);

 private:
  bool begun_ = false;
  std::chrono::microseconds offset_{}, last_{};
  Instant last_at_{};
};

class FrameRecording {
 public:
  /// `camera_name` becomes part of the camera metadata. The start of the recording (UTC) is written
  /// with its first frame. A copy of a recording keeps the original's start.
  /// Fails with kUnavailable or kInvalid if the file cannot be created.
  static Result<FrameRecording> open(const std::string& path, const sensor::SensorDescription& sensor,
                                     const std::string& camera_name);

  const std::string& path() const { return writer_.path(); }

  /// Writes a frame. Fails with kInvalid or kUnsupported if the recording has to leave out this
  /// frame. Fails with kUnavailable if nothing more can be written; call finish() then.
  Result<void> write(const RgbdFrame& frame);

  /// Makes sure that the frames written so far survive the end of this process.
  Result<void> checkpoint() { return writer_.checkpoint(); }

  /// Completes the file and checks it like a replay does. Call finish() once, at the end. A file of
  /// more than kMostChecked frames is not checked, because a stop has too little time for that.
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
