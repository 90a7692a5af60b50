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
  /// `camera_name` goes into the camera's note.
  /// Fails (kUnavailable, kInvalid) where the file cannot be made.
  static Result<FrameRecording> open(const std::string& path, const sensor::SensorDescription& sensor,
                                     const std::string& camera_name);

  const std::string& path() const { return writer_.path(); }

  /// Fails  kInvalid, kUnsupported: this frame is left out; kUnavailable: no more can be written, finish().
  Result<void> write(const RgbdFrame& frame);

  /// What was written so far survives this process.
  Result<void> checkpoint() { return writer_.checkpoint(); }

  /// Call once, last.
  Result<void> finish() { return writer_.finish(); }

  std::uint64_t frames() const { return frames_; }
  std::uint64_t bytes() const { return writer_.bytes(); }

 private:
  FrameRecording(recording::OniWriter writer, bool has_color)
      : writer_(std::move(writer)), has_color_(has_color) {}

  recording::OniWriter writer_;
  bool has_color_;
  RecordingClock clock_;
  std::chrono::microseconds last_color_{};
  std::uint64_t frames_ = 0;
};

}  // namespace copresence::server
