#pragma once

// Where RgbdFrames come from: a camera (device_source.h) or a recording (recording_source.h).
//
// Depth is as the sensor measured it; 0 is a hole. Colour is the picture within half a depth period
// of it. Where there is none, the nearest picture within 100 ms is repeated: a late picture
// disturbs less than a missing one. Else the frame has no colour. SourceCounters count both cases.
//
// Thread: one thread of a process opens, reads and closes all of its sources, and lives until the
// process ends. OpenNI2 (2.2.0.33) stores the ids of all threads that have called it and later
// probes them with pthread_kill(). That crashes if such a thread has ended. next() may block and
// obeys its stop token.

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
  std::string name;  ///< of the device or the file, for messages
  std::string uri;   ///< of a device: open_device() opens this very device by it
  CameraModel depth;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;         ///< a Kinect v1's: no driver or recording reports its sensor's
  bool has_color = false;   ///< if false, `color` is meaningless and no frame has colour
  CameraModel color;        ///< of the colour camera, before registration
  Rigid3 color_from_depth;  ///< metres; identity if registered
  bool registered = false;  ///< depth and colour share one camera model
  /// Every depth that the sensor can report, in `unit`, ascending. Empty if unknown.
  std::vector<std::uint16_t> levels;
  double frames_per_second = 30;            ///< nominal
  std::optional<Rigid3> world_from_camera;  ///< if the camera or the recording knows its pose
  bool is_recording = false;
  std::optional<std::uint64_t> frames;  ///< depth frames in one pass of a recording
  /// Microseconds from 1970 (UTC) to the zero of the sensor's times, if a recording states it.
  std::optional<std::int64_t> unix_zero_us;
};

/// How a camera exposes its colour pictures and when its projector is on. Unset: as the device does
/// by default.
struct CameraControls {
  enum class Mode {
    kAutomatic,  ///< follows the light
    kFixed,      ///< stays at the automatic's values of the 60th frame, so that cameras agree over time
  };
  std::optional<Mode> exposure, white_balance;
  std::optional<ProjectorSlot> projector;  ///< its time slot among the projectors of the room
};

/// How a recording is played. A camera has its own pace and no end.
struct SourceSettings {
  enum class Pace {
    kReal,  ///< by its timestamps; a pause of more than a second is shortened to one second
    kFast,  ///< every frame as soon as it is asked for
  };
  Pace pace = Pace::kReal;
  bool loop = false;  ///< begin again after the last frame, one mean period later
  /// At real pace: when the first frame is due. Default: in sync with the other replays of its
  /// session on this machine (session_clock.h), else at once. A past instant means at once.
  std::optional<Instant> begin = {};
  CameraControls controls = {};  ///< of a camera
};

/// Every picture that a source received is in a frame or counted here. The exception is a camera's
/// depth before its first colour picture. Colour that arrives while the projector is off has no
/// depth.
struct SourceCounters {
  std::uint64_t frames = 0;  ///< delivered
  std::uint64_t depth_without_color =
      0;  ///< delivered without colour of their instant, though there is a stream
  std::uint64_t color_without_depth = 0;  ///< colour pictures in no frame
  std::uint64_t damaged = 0;              ///< pictures that did not decode, or that a recording lacks
  /// A camera's pictures that never reached this process: lost on the way, or replaced by the next
  /// one in the driver.
  std::uint64_t late = 0;
  std::uint64_t projector_off = 0;  ///< depth pictures exposed outside the projector's own time slot, dropped
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const SensorDescription& description() const = 0;
  virtual SourceCounters counters() const = 0;

  /// Blocks until the next frame. Sequence numbers count from 1 and continue over a loop's seam.
  /// The capture instant is when this process received the frame; for a recording at real pace,
  /// when the frame is due. The pose is the description's. `durations.capture` is the time spent
  /// reading and converting, without waiting for the sensor.
  /// Fails  kEndOfStream: a recording's end, or a stop request.
  /// Fails  kCorrupt: no depth picture of a recording could be decoded for a second, or to its end.
  ///        Call again: the recording plays on at its pace.
  /// Fails  kTimeout: a camera sent nothing for a second.
  /// Fails  kUnavailable: the camera is gone. Open the source again, unless it does so itself
  ///        (reconnecting_source.h). For a recording: its session shows nothing of it for a second.
  ///        Call again.
  virtual Result<RgbdFrame> next(std::stop_token stop) = 0;
};

}  // namespace copresence::sensor
