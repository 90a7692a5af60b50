#pragma once

// What calibration reads, one per camera: recordings, or the streams of running servers; as frames with colour and depth
// in one camera model.

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_server/registration/registration.h"
#include "capture_server/sensor/frame_source.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "common/scene/scene.h"

namespace copresence::calibrate {

/// NAME=FILE.oni or NAME=HOST:PORT of the command line.
struct NamedSource {
  std::string name;        ///< the camera's, as in the scene file
  std::string from;        ///< a recording's path, or where a capture_server listens
  bool is_stream = false;  ///< the latter
};

/// `--recording NAME=FILE.oni` and `--stream NAME=HOST:PORT`, in any mixture. A wrong one, one name twice, and fewer than
/// `fewest` in all are a wrong command line. Both are returned.
struct SourceOptions {
  CLI::Option *recording, *stream;
};
SourceOptions add_source_options(CLI::App& parser, std::vector<NamedSource>& sources, std::size_t fewest,
                                 std::size_t most);

/// One camera's recording or stream, read frame by frame. Thread: one thread per object.
class Capture {
 public:
  enum class Form {
    kRegistered,   ///< colour brought to depth's camera
    kAsDelivered,  ///< each in its own camera, as the sensor gives them
  };

  /// known   what the scene file says of this camera; nullptr where it says nothing. Its intrinsics win over the
  ///         recording's own, its pose too.
  /// A stream is registered by its server, in whichever form. Fails  as open_source() or open_stream(), and kInvalid where the scene's picture size is not the recording's.
  static Result<Capture> open(const NamedSource& source, const scene::Camera* known,
                              Form form = Form::kRegistered);

  const std::string& name() const { return name_; }
  bool is_stream() const { return is_stream_; }
  const CameraModel& model() const { return sensor_.depth; }  ///< of depth, and of registered colour
  DepthUnit unit() const { return sensor_.unit; }
  bool has_color() const { return sensor_.has_color; }
  const std::optional<Rigid3>& world_from_camera() const { return sensor_.world_from_camera; }
  std::optional<std::uint64_t> frames() const { return sensor_.frames; }
  /// What the recording and the scene file say of the sensor, before registration.
  const sensor::SensorDescription& sensor() const { return sensor_; }

  /// Fails  kEndOfStream after the last frame, else as FrameSource::next().
  Result<RgbdFrame> next();

 private:
  Capture(std::string name, bool is_stream, std::unique_ptr<sensor::FrameSource> source,
          sensor::SensorDescription sensor, registration::Registration registration);

  std::string name_;
  bool is_stream_;
  std::unique_ptr<sensor::FrameSource> source_;
  sensor::SensorDescription sensor_;
  registration::Registration registration_;
};

/// Opens each source and lets it go: what is not there shows before anything has been taken from the others.
/// Fails  as Capture::open().
Result<void> try_all(std::span<const NamedSource> sources, const scene::Scene* scene);

/// How many frames look_at_frames() will look at, if the source does not end before: `most`, or all of a shorter recording.
std::size_t frames_to_look_at(const Capture& capture, std::size_t most);

/// True for about `wanted` of the numbers 0 to `all` - 1, evenly spread; always for 0.
bool is_among(std::size_t wanted, std::size_t number, std::size_t all);

/// Calls `look` with at most `most` frames, spread evenly over a recording, or `pause` apart in a stream; keeps none. What
/// `look` returns is printed to standard error behind the picture's number, unless it is empty. Returns how many frames
/// there were.
/// Fails  as Capture::next(), but not at the recording's end; kCorrupt where there is no frame at all. `look` has been called
///        for the frames before.
using Look = std::function<std::string(RgbdFrame)>;
Result<std::size_t> look_at_frames(Capture& capture, std::size_t most, Duration pause, const Look& look);

}  // namespace copresence::calibrate
