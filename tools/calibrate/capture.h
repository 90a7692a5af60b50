#pragma once

// Reads the input of all commands: one recording or one stream of a running server per camera.
// Frames have colour and depth in one camera model. Video coding adds errors to the frames of a
// stream, and a mean over frames removes most of them. Filled holes become holes again.

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

/// A source on the command line: NAME=FILE.oni or NAME=HOST:PORT.
struct NamedSource {
  std::string name;        ///< The camera's name in the scene file.
  std::string from;        ///< Path of a recording, or address of a capture_server.
  bool is_stream = false;  ///< True if `from` is an address.
  std::string key;         ///< Path of the key file of --key for a stream, or empty.
};

/// Adds the options `--recording NAME=FILE.oni`, `--stream NAME=HOST:PORT` and `--key FILE`. Parsing
/// fails for a source of another form, a repeated name, or fewer than `fewest` or more than `most`
/// sources.
struct SourceOptions {
  CLI::Option *recording, *stream;
};
SourceOptions add_source_options(CLI::App& parser, std::vector<NamedSource>& sources, std::size_t fewest,
                                 std::size_t most);

/// Stores the key file of --key in the scene, if there is one.
void remember_key(std::span<const NamedSource> sources, scene::Scene& scene);

/// Reads one camera's recording or stream frame by frame. Thread: one thread per object.
class Capture {
 public:
  enum class Frames {
    kRegistered,   ///< Colour is mapped to the depth camera.
    kAsDelivered,  ///< Colour and depth in their own cameras, as the sensor gives them.
  };

  /// `scene` is the scene file and may be null. Its intrinsics and pose of the camera replace those
  /// of the source. Its key is used for a stream without --key.
  /// A stream is always registered by its server. Opening waits up to two seconds for the server's
  /// answer.
  /// Fails as open_source(), tls::read_key() or wire::FrameClient::connect() does. Fails with kUnsupported for an
  /// unknown codec, and with kInvalid if the scene file has another picture size.
  static Result<Capture> open(const NamedSource& source, const scene::Scene* scene,
                              Frames frames = Frames::kRegistered);

  const std::string& name() const { return name_; }
  bool is_stream() const { return is_stream_; }
  /// Camera model of depth and of registered colour.
  const CameraModel& model() const { return sensor_.depth; }
  DepthUnit unit() const { return sensor_.unit; }
  bool has_color() const { return sensor_.has_color; }
  const std::optional<Rigid3>& world_from_camera() const { return sensor_.world_from_camera; }
  std::optional<std::uint64_t> frames() const { return sensor_.frames; }
  /// The sensor before registration, as the source and the scene file describe it.
  const sensor::SensorDescription& sensor() const { return sensor_; }

  /// Fails with kEndOfStream after the last frame. Fails with kTimeout and the server's own message
  /// if a server sends no frame for ten seconds. Otherwise fails as FrameSource::next() does.
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

/// Opens and closes each source, so that a missing one is reported before any frames are read.
/// Fails as Capture::open() does.
Result<void> check_sources(std::span<const NamedSource> sources, const scene::Scene* scene);

/// Number of frames that for_each_frame() will read: `most`, or all frames of a shorter recording.
std::size_t frames_to_read(const Capture& capture, std::size_t most);

/// True for about `wanted` evenly spaced values of `number` from 0 to `all` - 1. Always true for 0.
bool is_sampled(std::size_t wanted, std::size_t number, std::size_t all);

/// Calls `visit` with at most `most` frames: evenly spaced in a recording, or `pause` apart in a
/// stream. Prints the text that `visit` returns, if any, with the frame's number to standard error.
/// Returns the number of frames.
/// Fails as Capture::next() does, except at the end of a recording. Fails with kCorrupt if there is
/// no frame. All frames before the error reach `visit`.
using Visit = std::function<std::string(RgbdFrame)>;
Result<std::size_t> for_each_frame(Capture& capture, std::size_t most, Duration pause, const Visit& visit);

}  // namespace copresence::calibrate
