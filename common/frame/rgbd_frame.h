#pragma once

// One instant of one camera: depth, colour and metadata, as captured by the server and as decoded
// by the client.

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/frame/image.h"
#include "common/frame/rigid3.h"

namespace copresence {

/// An instant on a monotonic clock. A frame's instants are on its server's clock; the client maps
/// them to its own clock (common/wire).
using Instant = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

/// Identity, time and pose of a frame; unchanged from sensor to screen.
struct FrameMetadata {
  std::uint64_t sequence = 0;  ///< counts captured frames of one stream from 1, without gaps at the sensor
  Instant captured_at{};       ///< when the capture process received the frame, on its monotonic clock
  Rigid3 world_from_camera;    ///< the camera's pose at that instant, metres

  friend bool operator==(const FrameMetadata&, const FrameMetadata&) = default;
};

/// How long each of the server's stages took for one frame. They are sent with it, since the two
/// ends' clocks differ.
struct StageDurations {
  Duration capture{}, fill{}, depth_encode{}, video_encode{};
};

/// When the sensor took a frame's pictures, by its own clock. Only differences are meaningful,
/// since the clock's zero is arbitrary. These times stay in the capture process.
struct SensorTimes {
  std::chrono::microseconds depth{};
  std::chrono::microseconds color{};  ///< meaningless without colour
  bool color_is_repeated = false;     ///< an earlier frame had this colour picture, too
};

struct RgbdFrame {
  FrameMetadata metadata;
  DepthImage depth;  ///< in the stream's DepthUnit, along the optical axis; 0 exactly where state is kHole
  StateImage state;  ///< same shape as depth
  std::optional<ColorImage> color;  ///< from registration on: same shape and camera model as depth
  StageDurations durations;
  SensorTimes sensor_times;
};

}  // namespace copresence
