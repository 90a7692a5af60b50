#pragma once

// Properties of this project's drivers beyond OpenNI2's own. Their numbers do not overlap with
// OpenNI2's and PrimeSense's. A wrong size is refused with ONI_STATUS_BAD_PARAMETER.
//
// Thread: values.

#include <array>

namespace copresence::drivers {

/// Device, read: the pose world_from_camera as three rows of three rotation columns and the
/// translation in metres. Only simulated cameras know it.
inline constexpr int kPose = 0x43500001;
using Pose = std::array<double, 12>;

/// Stream, read: fx, fy, cx, cy in pixels, if the driver knows more than a field of view.
inline constexpr int kIntrinsics = 0x43500002;
using Intrinsics = std::array<double, 4>;

/// Depth stream, read: an std::uint16_t for each disparity, its depth in the stream's unit, or 0.
/// This is PrimeSense's property XN_STREAM_PROPERTY_S2D_TABLE of PS1080.h, which third-party
/// cameras and recordings have, too.
inline constexpr int kDepthOfDisparity = 0x10801010;

/// Device, read and write, double: degrees of the camera's tilt above the horizon, -30 to 30.
inline constexpr int kTilt = 0x43500003;

/// Device, write, int: the light on its front, a value of Light.
inline constexpr int kLight = 0x43500004;
enum class Light { kOff = 0, kGreen = 1, kRed = 2, kYellow = 3, kBlinkingGreen = 4, kBlinkingRedYellow = 6 };

/// Device, read and write, int 0 or 1: depth from 0.4 m instead of 0.8 m. Kinect for Windows only;
/// any other device answers ONI_STATUS_NOT_SUPPORTED.
inline constexpr int kNearMode = 0x43500005;

/// Device, read and write, int 0 or 1: whether its projector is on. It is on when the device is
/// opened. Without its projector a camera has no depth: its depth pictures are empty or missing.
inline constexpr int kProjector = 0x43500006;

}  // namespace copresence::drivers
