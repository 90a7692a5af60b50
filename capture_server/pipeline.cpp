#include "capture_server/pipeline.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "capture_server/capture_stage.h"
#include "capture_server/encode_stage.h"
#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/recorder/recording_thread.h"
#include "common/scene/scene.h"
#include "common/wire/frame_server.h"
#include "common/wire/message.h"

namespace copresence::server {
namespace {

// Time for the disk to write the frames in the queue. A stop must be complete within a second.
constexpr std::chrono::milliseconds kDrainWhenStopped{400}, kDrainAtTheEnd{3000};

Result<std::optional<scene::Camera>> camera_in_scene(const ServerSettings& settings) {
  if (settings.scene.empty()) return std::optional<scene::Camera>();
  const auto scene = scene::load(settings.scene);
  if (!scene) return fail(scene.error());
  const scene::Camera* camera = scene->find(settings.name);
  if (!camera) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: no camera is called \"{}\": give one of its names with --name",
                            settings.scene, settings.name));
  }
  return std::optional(*camera);
}

/// Returns null without --record.
Result<std::unique_ptr<RecordingThread>> begin_recording(const ServerSettings& settings,
                                                         const sensor::SensorDescription& sensor) {
  if (settings.record.empty()) return nullptr;
  auto recording = FrameRecording::open(settings.record, sensor, settings.name);
  if (!recording) return fail(recording.error());
  return std::make_unique<RecordingThread>(std::move(*recording));
}

/// The parts of the pipeline that are opened after the source.
struct Parts {
  std::unique_ptr<RecordingThread> recording;  // Null without --record.
  std::optional<FrameEncoding> encoding;
  std::unique_ptr<wire::FrameServer> server;
};

Result<Parts> open_parts(const ServerSettings& settings, const scene::Camera* camera,
                         const sensor::SensorDescription& sensor, const wire::ListeningSocket& listening,
                         const tls::RoomKey* key, Heartbeat& heartbeat) {
  heartbeat.enter(Stage::kPreparing);
  auto encoding = [&] {
    const auto activity = heartbeat.doing("preparing to fill holes and to encode",
                                          "start it with --compute cpu, which needs no graphics driver");
    return FrameEncoding::open(sensor, camera, settings);
  }();
  if (!encoding) return fail(encoding.error());
  auto server = wire::FrameServer::open(listening, encoding->description(), key,
                                        [&settings](const std::string& sentence, bool is_warning) {
                                          spdlog::log(is_warning ? spdlog::level::warn : spdlog::level::info,
                                                      "{}: {}", settings.name, sentence);
                                        });
  if (!server) return fail(server.error());
  auto recording = [&] {
    const auto activity = heartbeat.doing(fmt::format("creating the recording {}", settings.record),
                                          "its disk does not answer: record to another one");
    return begin_recording(settings, sensor);
  }();
  if (!recording) return fail(recording.error());
  const StreamDescription& stream = encoding->description();
  spdlog::info("{}: {}x{} {}, depth {} at {}{}, on {}", settings.name, stream.model.width,
               stream.model.height, stream.has_color ? "depth and colour" : "depth only", settings.codec,
               depth_quality(settings.encoder), key ? ", encrypted" : "", listening.address());
  return Parts{std::move(*recording), std::move(*encoding), std::move(*server)};
}

/// Returns the last message to the clients. After kAllFramesAreSent and kRecordingIsOver, clients
/// do not wait for this server to return.
std::string farewell(const Result<void>& result, const std::stop_token& stop, bool has_all_frames) {
  if (!result) return result.error().what;
  if (stop.stop_requested()) return "the server was stopped";
  return std::string(has_all_frames ? wire::kAllFramesAreSent : wire::kRecordingIsOver);
}

/// Runs until the capture has ended and its last frame is encoded.
Result<void> stream_frames(Parts& parts, sensor::FrameSource& source, const ServerSettings& settings,
                           std::optional<Instant> begin, flow::Mailbox<EncoderSettings>& encoder_changes,
                           const std::stop_token& stop, Heartbeat& heartbeat, CaptureThread& capture) {
  wire::FrameServer& server = *parts.server;
  flow::Mailbox<CapturedFrame> captured;
  CaptureStage capture_stage(settings, begin, source, parts.recording.get(), server, heartbeat);
  EncodeStage encode_stage(settings, *parts.encoding, server, encoder_changes);

  heartbeat.enter(Stage::kRunning);
  heartbeat.main().rest();  // This thread now runs the encode stage, which has its own pulse.
  std::jthread wire([&server, pulse = heartbeat.pulse("wire")](const std::stop_token& end) mutable {
    pthread_setname_np(pthread_self(), "wire");
    server.run(end, [&] { pulse.beat(); });
    pulse.rest();
  });
  Result<void> captures;
  std::stop_source end_capture;
  const std::stop_callback stop_too(stop, [&] { end_capture.request_stop(); });
  auto capture_ended = capture.begin([&, pulse = heartbeat.pulse("capture")]() mutable {
    captures = capture_stage.run(captured, end_capture.get_token(), pulse);
    captured.close();
    pulse.rest();
  });
  const Result<void> encodes = encode_stage.run(captured, heartbeat.pulse("encode"));
  end_capture.request_stop();
  capture_ended.get();
  heartbeat.enter(Stage::kEnding);
  capture_stage.log_missing_pictures();
  // The disk writes while the viewers receive the last frames.
  if (parts.recording) parts.recording->end(stop.stop_requested() ? kDrainWhenStopped : kDrainAtTheEnd);

  const Result<void>& result = encodes ? captures : encodes;
  server.end(farewell(result, stop, capture_stage.has_all_frames()));
  wire.join();
  return result;
}

}  // namespace

Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          const tls::RoomKey* key, flow::Mailbox<EncoderSettings>& encoder_changes,
                          const std::stop_token& stop, Heartbeat& heartbeat, CaptureThread& capture) {
  const auto camera = [&] {
    const auto activity = heartbeat.doing(fmt::format("reading the scene file {}", settings.scene),
                                          "mend that file or start without --scene");
    return camera_in_scene(settings);
  }();
  if (!camera) return fail(camera.error());
  const std::optional<Instant> begin = first_frame_due(settings);
  auto source = open_source(settings, begin, stop, heartbeat, capture);
  if (!source) return fail(source.error());

  Result<void> result;
  auto parts = open_parts(settings, *camera ? &**camera : nullptr, (*source)->description(), listening, key,
                          heartbeat);
  if (parts) {
    result = stream_frames(*parts, **source, settings, begin, encoder_changes, stop, heartbeat, capture);
    if (parts->recording) {
      const auto activity =
          heartbeat.doing(fmt::format("writing the last frames of {}", parts->recording->path()), "");
      parts->recording.reset();  // Waits until all frames are written.
    }
  } else {
    result = fail(parts.error());
  }
  close_source(capture, std::move(*source), heartbeat);
  return result;
}

}  // namespace copresence::server
