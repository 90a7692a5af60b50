#pragma once

// The source of RgbdFrames: a camera (device_source.h) or a recording (recording_source.h).
//
// Depth is as the sensor measured it, and 0 is a hole. Colour is the picture within half a depth
// period of the depth picture. If there is none, the nearest picture within 100 ms is repeated,
// because a late picture disturbs less than a missing one. Otherwise the frame has no colour.
// SourceCounters count both cases.
//
// Thread: one thread of a process opens, reads and closes all of its sources, and lives until the
// process ends (capture_thread.h). next() may block, but obeys its stop token.

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "capture_server/sensor/projector_schedule.h"
#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::sensor {

/// A source's properties, known before its first frame.
struct SensorDescription {
  std::string name;  ///< Name of the device or the file, for messages.
  std::string uri;   ///< URI by which open_device() opens this very device.
  CameraModel depth;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;         ///< A Kinect v1's noise, since no driver or recording reports its own.
  bool has_color = false;   ///< If false, `color` is meaningless and no frame has colour.
  CameraModel color;        ///< The colour camera, before registration.
  Rigid3 color_from_depth;  ///< The colour camera's pose in metres; the identity if `registered`.
  bool registered = false;  ///< Depth and colour share one camera model.
  /// Every depth that the sensor can report, in `unit`, ascending. The list is empty if unknown.
  std::vector<std::uint16_t> levels;
  double frames_per_second = 30;            ///< Nominal frame rate.
  std::optional<Rigid3> world_from_camera;  ///< Pose of the camera. Nothing if the pose is unknown.
  bool is_recording = false;
  std::optional<std::uint64_t> frames;  ///< Number of depth frames in one pass of a recording.
  /// Microseconds from 1970 (UTC) to the zero of the sensor's times, if a recording states it.
  std::optional<std::int64_t> unix_zero_us;
};

/// How a camera exposes its colour pictures, and when its projector is on. Unset means default.
struct CameraControls {
  enum class Mode {
    kAutomatic,  ///< Follows the light.
    /// Stays at the values of the 60th frame, so that colours do not change during the stream.
    kFixed,
  };
  std::optional<Mode> exposure, white_balance;
  std::optional<ProjectorSlot> projector;  ///< The projector's time slot, if cameras take turns.
};

/// How a recording is played, and the controls of a camera.
struct SourceSettings {
  enum class Pace {
    /// Follows the timestamps, but shortens a pause of more than a second to one second.
    kReal,
    kFast,  ///< Delivers every frame as soon as the caller asks for it.
  };
  Pace pace = Pace::kReal;
  bool loop = false;  ///< True to play again from the start, one mean period after the last frame.
  /// The instant at which the first frame is due at real pace. By default the replay is in sync
  /// with the other replays of its session on this machine (session_clock.h), or starts at once. If
  /// the instant has passed, the first frame is due at once.
  std::optional<Instant> begin = {};
  CameraControls controls = {};  ///< Only for a camera.
};

/// Counts the pictures that a source received. Every picture is in a frame or counted as missing,
/// except a camera's depth before its first colour picture. Colour that arrives while the projector
/// is off counts as colour without depth.
struct SourceCounters {
  std::uint64_t frames = 0;  ///< Delivered frames.
  /// Frames delivered without colour of their instant, although the source has colour.
  std::uint64_t depth_without_color = 0;
  std::uint64_t color_without_depth = 0;  ///< Colour pictures that are in no frame.
  std::uint64_t damaged = 0;              ///< Pictures that did not decode, or that a recording lacks.
  /// Pictures of a camera that never reached this process, because they were lost on the way or
  /// replaced by newer ones in the driver.
  std::uint64_t late = 0;
  std::uint64_t projector_off = 0;  ///< Dropped depth pictures from outside the projector's time slot.
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const SensorDescription& description() const = 0;
  virtual SourceCounters counters() const = 0;

  /// Blocks until the next frame. Sequence numbers count from 1, also across the passes of a loop.
  /// The capture instant is the time at which this process received the frame. For a recording at
  /// real pace it is the time at which the frame is due. The pose is that of description().
  /// `durations.capture` is the time for reading and converting, without waiting for the sensor.
  /// Fails with kEndOfStream at a recording's end or on a stop request.
  /// Fails with kTimeout if a camera sent nothing for a second.
  /// Fails with kUnavailable if the camera is gone. Open the source again, unless it reconnects
  /// itself (reconnecting_source.h). A replay fails with kUnavailable while its session shows none
  /// of its frames for a second. Then call next() again.
  /// Fails with kCorrupt if no depth picture of a recording could be decoded for a second, or to
  /// its end. Call next() again: the recording plays on at its pace.
  virtual Result<RgbdFrame> next(std::stop_token stop) = 0;
};

}  // namespace copresence::sensor
