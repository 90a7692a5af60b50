#pragma once

// Describes a recording as a frame source.
// Thread: pure functions, safe anywhere.

#include <cstdint>
#include <optional>
#include <string>

#include "capture_server/recording/oni_check.h"
#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {

struct RecordingDescription {
  SensorDescription sensor;
  double period_us = 33'333;  ///< Usual time between depth frames.
  /// Length of one pass, from the first depth frame to one period after the last.
  std::int64_t duration_us = 0;
  std::int64_t first_us = 0;  ///< Timestamp of the first depth frame.
  /// Microseconds from 1970 (UTC) to the first depth frame. The value is set only if the recording
  /// states its start and its times increase.
  std::optional<std::int64_t> began_unix_us;
};

/// Intrinsics come from the recording's camera metadata, else from its field of view, else they are
/// a Kinect's. Without metadata, colour of the depth picture's size counts as registered: the
/// format does not state it, and recorders register by default. Requires a summary that
/// recording::check() returned for `path`.
RecordingDescription describe(const std::string& path, const recording::RecordingSummary& summary);

}  // namespace copresence::sensor
