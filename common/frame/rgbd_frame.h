#pragma once

// One instant of one camera: depth, colour and metadata, as captured by the server or decoded by
// the client.

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

/// Identity, time and pose of a frame, which stay unchanged from sensor to screen.
struct FrameMetadata {
  std::uint64_t sequence = 0;  ///< Counts the captured frames of a stream from 1, without gaps.
  Instant captured_at{};       ///< When the capture process received it, on its monotonic clock.
  Rigid3 world_from_camera;    ///< Pose of the camera at that instant, in metres.

  friend bool operator==(const FrameMetadata&, const FrameMetadata&) = default;
};

/// How long each stage of the server took for one frame. The durations are sent with the frame,
/// since the clocks of server and client differ.
struct StageDurations {
  Duration capture{}, fill{}, depth_encode{}, video_encode{};
};

/// When the sensor took a frame's pictures, by its own clock. Only differences are meaningful,
/// since the clock's zero is arbitrary. These times stay in the capture process.
struct SensorTimes {
  std::chrono::microseconds depth{};
  std::chrono::microseconds color{};  ///< Meaningless without colour.
  bool color_is_repeated = false;     ///< True if an earlier frame had this colour picture, too.
};

struct RgbdFrame {
  FrameMetadata metadata;
  DepthImage depth;                 ///< In the stream's DepthUnit; 0 exactly where state is kHole.
  StateImage state;                 ///< Same shape as depth.
  std::optional<ColorImage> color;  ///< Registered colour has the shape and camera model of depth.
  StageDurations durations;
  SensorTimes sensor_times;
};

}  // namespace copresence
