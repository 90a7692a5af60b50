#pragma once

// Properties of this project's drivers beyond OpenNI2's own. The properties' numbers do not overlap
// with those of OpenNI2 and PrimeSense. A value of a wrong size gives ONI_STATUS_BAD_PARAMETER.

#include <array>

namespace copresence::drivers {

/// Property of a device, read-only: the pose world_from_camera as three rows of three rotation
/// columns and the translation in metres. Only simulated cameras have this property.
inline constexpr int kPose = 0x43500001;
using Pose = std::array<double, 12>;

/// Property of a stream, read-only: fx, fy, cx and cy in pixels. Some drivers lack this property.
inline constexpr int kIntrinsics = 0x43500002;
using Intrinsics = std::array<double, 4>;

/// Property of a depth stream, read-only: for each disparity, its depth as std::uint16_t in the
/// stream's unit, or 0. The property is XN_STREAM_PROPERTY_S2D_TABLE of PrimeSense's PS1080.h.
/// Third-party cameras and recordings also have this property.
inline constexpr int kDepthOfDisparity = 0x10801010;

/// Property of a device, read and write, double: tilt above the horizon, -30 to 30 degrees.
inline constexpr int kTilt = 0x43500003;

/// Property of a device, write-only, int: the light on its front, a value of Light.
inline constexpr int kLight = 0x43500004;
enum class Light { kOff = 0, kGreen = 1, kRed = 2, kYellow = 3, kBlinkingGreen = 4, kBlinkingRedYellow = 6 };

/// Property of a device, read and write, int: 1 if depth starts at 0.4 m instead of 0.8 m, else 0.
/// Only Kinect for Windows has this property; other devices answer ONI_STATUS_NOT_SUPPORTED.
inline constexpr int kNearMode = 0x43500005;

/// Property of a device, read and write, int: 1 if its projector is on, else 0. The projector is on
/// when the device is opened. While the projector is off, depth pictures are empty or missing.
inline constexpr int kProjector = 0x43500006;

}  // namespace copresence::drivers
