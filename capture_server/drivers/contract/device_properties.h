#pragma once

// What the drivers of this project tell beyond OpenNI2's own properties. Numbers are far from OpenNI2's and PrimeSense's.
// Sizes are fixed: another one is refused with ONI_STATUS_BAD_PARAMETER.
//
// Thread: values.

#include <array>

namespace copresence::drivers {

/// Device, read: where the camera stands, world_from_camera as rows of three rotation columns and the translation in
/// metres. For simulated cameras, which know it.
inline constexpr int kPose = 0x43500001;
using Pose = std::array<double, 12>;

/// Stream, read: fx, fy, cx, cy in pixels, where the driver knows more than a field of view.
inline constexpr int kIntrinsics = 0x43500002;
using Intrinsics = std::array<double, 4>;

/// Depth stream, read, std::uint16_t for each disparity: the depth it stands for, in the stream's unit, 0 for none.
/// PrimeSense's own property, XN_STREAM_PROPERTY_S2D_TABLE of PS1080.h: cameras and recordings of others have it too.
inline constexpr int kDepthOfDisparity = 0x10801010;

/// Device, read and write, double: degrees of the camera's tilt above the horizon, -30 to 30.
inline constexpr int kTilt = 0x43500003;

/// Device, write, int: the light on its front, one of Light.
inline constexpr int kLight = 0x43500004;
enum class Light { kOff = 0, kGreen = 1, kRed = 2, kYellow = 3, kBlinkingGreen = 4, kBlinkingRedYellow = 6 };

/// Device, read and write, int 0 or 1: depth from 0.4 m instead of 0.8 m. Kinect for Windows only; any other device
/// answers ONI_STATUS_NOT_SUPPORTED.
inline constexpr int kNearMode = 0x43500005;

/// Device, read and write, int 0 or 1: whether its projector shines. Without its light a camera has no depth: its depth
/// pictures are empty or do not come. It shines when it is opened.
inline constexpr int kProjector = 0x43500006;

}  // namespace copresence::drivers
