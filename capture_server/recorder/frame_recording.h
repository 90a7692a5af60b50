#pragma once

// Records the sensor's frames: each depth picture bit by bit, each colour picture once, both with
// the sensor's own times. Frames are recorded before registration, range and hole filling, so that
// a replay runs all of these stages again.
//
// If the requested file exists, the first free name of `name-2.oni`, `name-3.oni` and so on is
// used. A recording never overwrites a file, not even after a crash or when several servers start
// at once.
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

/// Converts the sensor's time into a recording's, which never decreases. If the sensor's clock
/// restarts (it was plugged in again), the recording continues at its last time plus the time that
/// has passed since on this process's clock. Thread: a value.
class RecordingClock {
 public:
  /// The recording's time zero minus the sensor's, for this frame and later ones.
  std::chrono::microseconds offset_for(std::chrono::microseconds sensor_time, Instant captured_at);

 private:
  bool begun_ = false;
  std::chrono::microseconds offset_{}, last_{};
  Instant last_at_{};
};

class FrameRecording {
 public:
  /// `camera_name` becomes part of the camera metadata. The start of the recording (UTC) is noted
  /// with its first frame. A copy of a recording keeps the original's start; every other recording
  /// starts now.
  /// Fails (kUnavailable, kInvalid) if the file cannot be created.
  static Result<FrameRecording> open(const std::string& path, const sensor::SensorDescription& sensor,
                                     const std::string& camera_name);

  const std::string& path() const { return writer_.path(); }

  /// Fails  kInvalid, kUnsupported: this frame is left out; kUnavailable: nothing more can be
  ///        written, call finish().
  Result<void> write(const RgbdFrame& frame);

  /// The frames written so far then survive the death of this process.
  Result<void> checkpoint() { return writer_.checkpoint(); }

  /// Call once, at the end. The file is then checked as for a replay, up to kMostChecked frames:
  /// checking longer ones takes more time than a stop has.
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
