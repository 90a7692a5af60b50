#pragma once

// One instant of one camera: what leaves the sensor, and what the client has again after decoding.

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/frame/image.h"
#include "common/frame/rigid3.h"

namespace copresence {

/// An instant on a monotonic clock. A frame carries its server's; the client maps it to its own
/// (common/wire).
using Instant = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

/// What identifies a frame from sensor to screen.
struct FrameMetadata {
  std::uint64_t sequence = 0;  ///< counts captured frames of one stream from 1, without gaps at the sensor
  Instant captured_at{};       ///< when the capture process held the frame, on that process's monotonic clock
  Rigid3 world_from_camera;    ///< the camera's pose at that instant, metres

  friend bool operator==(const FrameMetadata&, const FrameMetadata&) = default;
};

/// How long the server's stages took for one frame. They travel beside it, since the two ends' clocks differ.
struct StageDurations {
  Duration capture{}, fill{}, depth_encode{}, video_encode{};
};

/// When the sensor took a frame's pictures, by its own clock: differences mean something, the zero does not. They
/// stay in the capture process.
struct SensorTimes {
  std::chrono::microseconds depth{};
  std::chrono::microseconds color{};  ///< meaningless without colour
  bool color_is_repeated = false;     ///< an earlier frame had this very colour picture already
};

struct RgbdFrame {
  FrameMetadata stamp;
  DepthImage depth;  ///< in the stream's DepthUnit, along the optical axis; 0 exactly where state is kHole
  StateImage state;  ///< same shape as depth
  std::optional<ColorImage> color;  ///< from registration on: same shape and camera model as depth
  StageDurations durations;
  SensorTimes sensor_times;
};

}  // namespace copresence
