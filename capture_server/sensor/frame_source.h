#pragma once

// Where RgbdFrames come from: a camera that OpenNI2 opens, or a recording that it plays.
//
// A frame's depth is the sensor's own: 0 is a hole, everything else is measured. Its colour is of the same
// instant where there is one within half a depth period; else the newest that is at most 100 ms away is shown
// again, since a picture slightly late disturbs less than one without colour; else there is none. The
// counters tell.
//
// Thread: one thread of a process opens, reads and closes all of its sources, and lives until the process ends. OpenNI2
// (2.2.0.33) keeps the ids of all threads that have called it and later asks with pthread_kill() whether they live, which
// crashes where the memory of one that has ended was given back. next() may block and obeys its stop token.

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "capture_server/diagnosis/usb_cameras.h"
#include "capture_server/sensor/projector_schedule.h"
#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::sensor {

/// What is known of a source before its first frame.
struct SensorDescription {
  std::string name;  ///< the device's or the file's, for people
  std::string uri;   ///< of a device: what open_device() takes for this very one
  CameraModel depth;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;         ///< a Kinect v1's: no driver or recording reports its sensor's
  bool has_color = false;   ///< where false, `color` is meaningless and no frame has colour
  CameraModel color;        ///< before registration: the colour camera's own
  Rigid3 color_from_depth;  ///< metres; identity where registered
  bool registered = false;  ///< depth and colour already share one camera model
  /// Every depth that the sensor can report, in `unit`, ascending; empty where it does not tell.
  std::vector<std::uint16_t> levels;
  double frames_per_second = 30;            ///< nominal
  std::optional<Rigid3> world_from_camera;  ///< where the recording says it
  bool is_recording = false;
  std::optional<std::uint64_t> frames;  ///< depth frames of one pass of a recording
  /// Microseconds from 1970 (UTC) to the zero of the sensor's times, where a recording says it.
  std::optional<std::int64_t> unix_zero_us;
};

/// How a camera exposes its colour pictures, and when it lights the room; the device's own way where nothing is said.
struct CameraControls {
  enum class Mode {
    kAutomatic,  ///< follows the light
    kFixed,  ///< keeps what the automatic has found by the 60th frame: several cameras stop disagreeing over time
  };
  std::optional<Mode> exposure, white_balance;
  std::optional<ProjectorSlot> projector;  ///< its turn among the projectors of the room
};

/// How a recording is played. A camera has its own pace and no end.
struct SourceSettings {
  enum class Pace {
    kReal,  ///< as its timestamps say; a pause of more than a second is shortened to one
    kFast,  ///< every frame as soon as it is asked for
  };
  Pace pace = Pace::kReal;
  bool loop = false;  ///< begin again after the last frame, one mean period later
  /// At real pace: when the first frame is due. By default in step with the other replays of its session on this machine
  /// (session_clock.h), else at once; also at once where it has passed.
  std::optional<Instant> begin = {};
  CameraControls controls = {};  ///< of a camera
};

/// What happened to the pictures a source got. Every one is in a frame or counted here, but for a camera's
/// depth before its colour is up. Of colour that comes while its projector is dark, none has depth.
struct SourceCounters {
  std::uint64_t frames = 0;               ///< handed over
  std::uint64_t depth_without_color = 0;  ///< of those: no colour of their instant, though there is a stream
  std::uint64_t color_without_depth = 0;  ///< colour pictures that no frame carried
  std::uint64_t damaged = 0;              ///< pictures that did not decode, or that a recording lacks
  /// Pictures of a camera that never reached this process: its driver had the next one before they were
  /// taken, or they were lost on their way from the camera.
  std::uint64_t late = 0;
  std::uint64_t dark = 0;  ///< depth pictures not exposed in the projector's own turn, left out
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const SensorDescription& description() const = 0;
  virtual SourceCounters counters() const = 0;

  /// Blocks until the next frame. Its sequence counts from 1 and goes on over a loop's seam; its capture instant
  /// is the moment at which this process holds it: for a recording played at real pace the instant at which it is
  /// due, before which it was read and decoded; its pose is the description's. durations.capture is the time that
  /// reading and converting took, without waiting for the sensor.
  /// Fails  kEndOfStream (a recording's end, and when asked to stop), kCorrupt (for a second, up to four where this process gets
  ///        no core, or to its end, no depth of a recording could be decoded), kTimeout (nothing came for a second; for four where this process gets no core),
  ///        kUnavailable (the camera is gone; of a recording: its session shows nothing of it for a second). After kCorrupt,
  ///        and after a recording's kUnavailable: call again, the recording plays on at its pace. After kTimeout
  ///        and kUnavailable: open the source again, unless it does that itself (lasting_source.h).
  virtual Result<RgbdFrame> next(std::stop_token stop) = 0;
};

/// A recording that has been checked, and what the check found out about it.
struct CheckedRecording {
  std::string path;
  SensorDescription description;
  std::uint64_t last_depth_frame =
      0;  ///< number of the last frame of each stream, which count from 1; at least 1
  std::uint64_t last_color_frame = 0;  ///< ... where there is colour
  double period_us = 33333;            ///< usual time between depth frames
  std::int64_t duration_us = 0;  ///< of one pass: from the first depth frame to one period after the last
  /// When the first depth frame was taken, microseconds since 1970; only where the recording notes it and its times rise.
  std::optional<std::int64_t> began_unix_us;
  std::int64_t first_us = 0;  ///< that frame's timestamp in the recording
};

/// Plays a checked recording through OpenNI2. Requires that recording::check() accepted the file: OpenNI2 crashes
/// or stalls on damaged ones.
/// Fails  kNotFound (the file is gone), kCorrupt (OpenNI2 does not take it).
Result<std::unique_ptr<FrameSource>> open_recording(const CheckedRecording& recording,
                                                    const SourceSettings& settings);

/// Opens a camera. `uri` as list_devices() gives it after "openni:"; empty for the first one there is. Chosen are depth at 640x480
/// and 30 frames a second or what comes nearest, RGB8 of the same size where there is colour, depth registered to
/// colour and both taken at once where the device can.
/// Fails  kNotFound (no such camera), kUnavailable (held by another program, no permission), kUnsupported (no
///        depth, controls that the camera does not offer, or OpenNI2 does not start).
Result<std::unique_ptr<FrameSource>> open_device(const std::string& uri, const CameraControls& controls = {});

/// The same for a camera that may be unplugged and plugged in again: see lasting_source.h. Whichever opened first is
/// waited for, not another one.
Result<std::unique_ptr<FrameSource>> open_lasting_device(const std::string& uri,
                                                         const CameraControls& controls = {});

/// A camera that is there, for people to choose from.
struct DeviceListing {
  std::string source;  ///< what --source takes; empty where it cannot be opened at all
  std::string name;    ///< vendor and model
  std::string serial;  ///< empty where it tells none
  std::string driver;
  std::vector<std::string> modes;     ///< "depth 640x480 at 30, 1 mm"
  std::vector<std::string> problems;  ///< one sentence each, with its mend
  bool ready = false;                 ///< whether it could be opened just now
};

/// Every camera that OpenNI2 sees, each opened for a moment to learn whether it can be, and those that only the USB bus
/// shows.
/// Fails  kUnavailable (OpenNI2 does not start).
Result<std::vector<DeviceListing>> list_devices(const UsbPlaces& places = {});

}  // namespace copresence::sensor
