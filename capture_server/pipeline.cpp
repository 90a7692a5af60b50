#include "capture_server/pipeline.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/recording/recording_thread.h"
#include "capture_server/sensor/reconnecting_source.h"
#include "capture_server/sensor/source.h"
#include "common/flow/drop_stale.h"
#include "common/flow/mailbox.h"
#include "common/flow/thread_priority.h"
#include "common/flow/waiting.h"
#include "common/flow/worker_pool.h"
#include "common/wire/frame_server.h"
#include "common/wire/message.h"

namespace copresence::server {
namespace {

// A stop must be over within a second.
constexpr std::chrono::milliseconds kDrainWhenStopped{400}, kDrainAtTheEnd{3000};

/// A frame on its way from the capture to the encode thread, with the sensor's losses as they stood when it
/// came.
struct Captured {
  RgbdFrame frame;
  sensor::SourceCounters pictures;
};

/// Steps of nice. Encoding gives way to a render_client on the same machine, whose view would stutter: a
/// frame more of latency is better. A recording's player, which reads ahead on threads of its own, gives way
/// to encoding, too: it begins with the next frame just when the last one is being encoded.
constexpr int kStepsBehindTheView = 5, kStepsBehindAll = 10;

/// Between two tries to open a camera, and between two sentences about it.
constexpr std::chrono::milliseconds kBetweenTries = sensor::ReconnectingSource::kBetweenTries;
constexpr std::chrono::seconds kBetweenSentences{10};

void name_this_thread(const char* name) {
  pthread_setname_np(pthread_self(), name);
}

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

/// On the capture thread. Cameras' threads keep their priority: they have the USB to serve.
Result<std::unique_ptr<sensor::FrameSource>> open_source_once(const ServerSettings& settings,
                                                              std::optional<Instant> begin) {
  const flow::NewThreads player;
  auto source = open_source(
      settings.source,
      {.pace = settings.pace, .loop = settings.loop, .begin = begin, .controls = settings.controls});
  if (is_recording(settings.source)) player.lower_priority(kStepsBehindAll);
  return source;
}

/// After a crash the camera was there before: "not found" then means unplugged, or that its driver still
/// holds it. Any other error is final, and so is every error of a recording.
bool may_come_back(const Error& error, const ServerSettings& settings, const Heartbeat& heartbeat) {
  return heartbeat.predecessor().existed && !is_recording(settings.source) &&
         (error.code == ErrorCode::kNotFound || error.code == ErrorCode::kUnavailable);
}

/// Fails with kEndOfStream when asked to stop.
Result<std::unique_ptr<sensor::FrameSource>> open_source_to_play(const ServerSettings& settings,
                                                                 std::optional<Instant> begin,
                                                                 const std::stop_token& stop,
                                                                 Heartbeat& heartbeat,
                                                                 CaptureThread& capture) {
  heartbeat.enter(Stage::kOpening);
  std::optional<Instant> said;
  while (true) {
    heartbeat.main().open();
    Result<std::unique_ptr<sensor::FrameSource>> source;
    capture.run([&] { source = open_source_once(settings, begin); });
    if (source || !may_come_back(source.error(), settings, heartbeat)) return source;
    const Instant now = std::chrono::steady_clock::now();
    if (!said || now >= *said + kBetweenSentences) {
      said = now;
      spdlog::warn("{}; waiting for it", source.error().what);
    }
    wait_for(kBetweenTries, stop);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
  }
}

/// When a recording is to begin, by the clock that its frames are played by.
std::optional<Instant> beginning(const ServerSettings& settings) {
  if (!settings.start_at) return std::nullopt;
  using Seconds = std::chrono::duration<double>;
  const Seconds ahead = Seconds(*settings.start_at) - std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<Duration>(ahead);
}

/// Nothing where none is asked for.
Result<std::unique_ptr<RecordingThread>> begin_recording(const ServerSettings& settings,
                                                         const sensor::SensorDescription& sensor) {
  if (settings.record.empty()) return nullptr;
  auto recording = FrameRecording::open(settings.record, sensor, settings.name);
  if (!recording) return fail(recording.error());
  return std::make_unique<RecordingThread>(std::move(*recording));
}

std::string in_words(const EncoderSettings& rates) {
  return rates.depth_kbps ? fmt::format("{} kbit/s", *rates.depth_kbps)
                          : fmt::format("qp {}", rates.depth_qp);
}

/// A source is closed by the thread that opened it.
void close_source(CaptureThread& capture, std::unique_ptr<sensor::FrameSource> source, Heartbeat& heartbeat) {
  heartbeat.main().open();
  capture.run([&] { source.reset(); });
  heartbeat.main().rest();
}

class Pipeline {
 public:
  Pipeline(const ServerSettings& settings, std::optional<Instant> begin,
           std::unique_ptr<sensor::FrameSource> source, std::unique_ptr<RecordingThread> recording,
           FrameEncoding encoding, std::unique_ptr<wire::FrameServer> server,
           flow::Mailbox<EncoderSettings>& rates, Heartbeat& heartbeat, CaptureThread& capture)
      : heartbeat_(heartbeat),
        capture_(capture),
        settings_(settings),
        begin_(begin),
        rates_(settings.rates),
        new_rates_(rates),
        source_(std::move(source)),
        recording_(std::move(recording)),
        encoding_(std::move(encoding)),
        server_(std::move(server)) {}

  ~Pipeline() { close_source(capture_, std::move(source_), heartbeat_); }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// On the thread that opened the encoding: a graphics context may belong to it.
  Result<void> run(const std::stop_token& stop) {
    heartbeat_.enter(Stage::kRunning);
    heartbeat_.main().rest();  // it encodes, which has a pulse of its own
    std::jthread wire([this, pulse = heartbeat_.pulse("wire")](const std::stop_token& end) mutable {
      name_this_thread("wire");
      server_->run(end, [&] { pulse.beat(); });
      pulse.rest();
    });
    Result<void> captured;
    const std::stop_callback stop_too(stop, [this] { end_capture_.request_stop(); });
    auto capture_ended = capture_.begin([&, pulse = heartbeat_.pulse("capture")]() mutable {
      captured = capture_frames(end_capture_.get_token(), pulse);
      captured_.close();
      pulse.rest();
    });
    const Result<void> encoded = encode_frames(heartbeat_.pulse("encode"));
    end_capture_.request_stop();
    capture_ended.get();
    heartbeat_.enter(Stage::kEnding);
    say_what_was_left_out(source_->counters());
    // The disk has its time while the viewers are told.
    if (recording_) recording_->end(stop.stop_requested() ? kDrainWhenStopped : kDrainAtTheEnd);

    const Result<void>& result = encoded ? captured : encoded;
    server_->end(farewell(result, stop));
    wire.join();
    return result;
  }

  /// After run(): waits until what is to be recorded is written, however long the disk takes.
  void finish_recording() {
    if (!recording_) return;
    const auto activity =
        heartbeat_.doing(fmt::format("writing the last frames of {}", recording_->path()), "");
    recording_.reset();
  }

 private:
  /// What clients are told at the end. Two of the reasons say that it is no use to wait for this server.
  std::string farewell(const Result<void>& result, const std::stop_token& stop) const {
    if (!result) return result.error().what;
    if (stop.stop_requested()) return "the server was stopped";
    return std::string(has_all_frames_ ? wire::kAllFramesAreSent : wire::kRecordingIsOver);
  }

  Result<void> capture_frames(const std::stop_token& stop, Pulse& pulse) {
    wait_for_the_beginning(stop, pulse);
    while (!stop.stop_requested()) {
      may_open_anew() ? pulse.open() : pulse.beat();
      auto frame = source_->next(stop);
      pulse.beat();
      if (!frame) {
        if (frame.error().code == ErrorCode::kEndOfStream) return {};
        if (!goes_on(frame.error())) return fail(frame.error());
        say_no_frames(frame.error());
        continue;
      }
      say_frames_again();
      has_begun_ = true;
      const std::uint64_t sequence = frame->metadata.sequence;
      heartbeat_.captured(sequence);
      if (keeps_every_frame()) pulse.rest();  // the disk and the encoder set the pace
      if (recording_) recording_->offer(*frame, keeps_every_frame(), stop);
      if (keeps_every_frame()) captured_.wait_until_taken(stop);
      captured_.put({std::move(*frame), source_->counters()});
      if (settings_.frames && sequence >= *settings_.frames) {
        has_all_frames_ = true;
        return {};
      }
    }
    return {};
  }

  // Whether the source's next() may take as long as opening a camera and waiting for its first frame.
  bool may_open_anew() const { return !is_recording(settings_.source) && (!has_begun_ || no_frames_since_); }

  // A recording that is played as fast as frames can be sent waits for the encoder.
  bool keeps_every_frame() const {
    return settings_.pace == sensor::SourceSettings::Pace::kFast && is_recording(settings_.source);
  }

  // Until shortly before: the source itself waits for the instant.
  void wait_for_the_beginning(const std::stop_token& stop, Pulse& pulse) const {
    constexpr std::chrono::milliseconds kShortly{200};
    if (!begin_) return;
    const std::chrono::duration<double> ahead = *begin_ - std::chrono::steady_clock::now();
    if (ahead > kShortly) spdlog::info("{}: begins in {:.1f} s", settings_.name, ahead.count());
    while (!stop.stop_requested() && std::chrono::steady_clock::now() + kShortly < *begin_) {
      pulse.beat();
      wait_for(kShortly, stop);
    }
  }

  void say_what_was_left_out(const sensor::SourceCounters& pictures) const {
    if (pictures.damaged) {
      spdlog::warn("{}: {} depth or colour pictures were damaged{}", settings_.name, pictures.damaged,
                   is_recording(settings_.source) ? " or are missing from the recording" : "");
    }
    if (pictures.late) {
      spdlog::info(
          "{}: {} depth or colour pictures came too late and were skipped: this machine{} was too busy to "
          "take them before the next ones",
          settings_.name, pictures.late, settings_.source.starts_with("openni:") ? " or its USB" : "");
    }
    if (pictures.dark) {
      spdlog::info("{}: {} depth pictures were taken outside its projector's turns and left out",
                   settings_.name, pictures.dark);
    }
  }

  // A camera may be plugged in again, and a damaged recording may have better places; one that fails stays
  // so.
  bool goes_on(const Error& error) const {
    if (is_recording(settings_.source)) {
      return error.code == ErrorCode::kCorrupt || error.code == ErrorCode::kUnavailable;
    }
    return error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kTimeout;
  }

  void say_no_frames(const Error& why) {
    if (std::exchange(no_frames_since_, why.code)) return;
    const bool is_damaged = why.code == ErrorCode::kCorrupt;
    // A recording that loops is damaged again and again.
    if (!is_damaged || !std::exchange(damage_is_said_, true))
      spdlog::warn("{}; {}", why.what, is_damaged ? "playing on" : "waiting for it");
    server_->set_camera_status(why.what);
  }

  void say_frames_again() {
    const auto reason = std::exchange(no_frames_since_, std::nullopt);
    if (!reason) return;
    if (*reason != ErrorCode::kCorrupt) spdlog::info("{}: the camera is back", settings_.name);
    server_->set_camera_status({});
  }

  /// Until the capture ends and its last frame is encoded. Fails with what no later frame can mend.
  Result<void> encode_frames(Pulse pulse) {
    flow::lower_priority(kStepsBehindTheView);
    flow::WorkerPool workers(std::thread::hardware_concurrency() > 1 ? 2 : 1, "encode");
    bool keyframe_owed = false;      // a frame that was to be one failed
    std::uint64_t without_room = 0;  // frames left out since nobody was there, or nobody had room
    std::uint64_t encoder_busy = 0;  // frames that newer ones replaced or overtook, or that failed
    std::uint64_t last = 0;          // sequence
    const Duration period = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(1 / encoding_.description().frames_per_second));
    for (Instant free = std::chrono::steady_clock::now(); auto captured = captured_.take({});
         free = std::chrono::steady_clock::now(), pulse.rest()) {
      pulse.beat();
      if (const auto rates = new_rates_.try_take()) change_rates(*rates);
      const std::uint64_t sequence = captured->frame.metadata.sequence;
      if (sequence > last) encoder_busy += sequence - last - 1;
      last = sequence;
      if (!server_->wants_frames()) {
        ++without_room;
        continue;
      }
      if (!keeps_every_frame() &&
          flow::should_drop_stale(captured->frame.metadata.captured_at, free, period)) {
        ++encoder_busy;
        continue;
      }
      const bool keyframe = server_->take_keyframe_request() || keyframe_owed;
      auto encoded = encoding_.encode(std::move(captured->frame), keyframe, &workers);
      keyframe_owed = !encoded;
      if (encoded) {
        server_->send(std::make_shared<const EncodedFrame>(std::move(*encoded)),
                      {sequence, encoder_busy, without_room, captured->pictures.depth_without_color,
                       captured->pictures.color_without_depth, captured->pictures.damaged,
                       captured->pictures.late, captured->pictures.dark});
      } else if (encoded.error().code == ErrorCode::kUnsupported) {
        if (!rates_before_) return fail(encoded.error());
        ++encoder_busy;
        spdlog::warn("{}: {}; depth goes on at {}", settings_.name, encoded.error().what,
                     in_words(*rates_before_));
        change_rates(EncoderSettings(*rates_before_));
        rates_before_.reset();
      } else {
        ++encoder_busy;
        spdlog::warn("{}: frame {} is left out: {}", settings_.name, sequence, encoded.error().what);
      }
    }
    return {};
  }

  void change_rates(const EncoderSettings& rates) {
    if (const auto changed = encoding_.set_rates(rates); !changed) {
      spdlog::warn("{}: {}; rates stay as they are", settings_.name, changed.error().what);
      return;
    }
    rates_before_ = std::exchange(rates_, rates);
  }

  Heartbeat& heartbeat_;
  CaptureThread& capture_;
  const ServerSettings& settings_;
  const std::optional<Instant> begin_;
  EncoderSettings rates_;
  std::optional<EncoderSettings> rates_before_;  ///< of a change while running: what can be gone back to
  flow::Mailbox<EncoderSettings>& new_rates_;
  std::unique_ptr<sensor::FrameSource> source_;
  std::unique_ptr<RecordingThread> recording_;  ///< where there is one
  FrameEncoding encoding_;
  std::unique_ptr<wire::FrameServer> server_;
  flow::Mailbox<Captured> captured_;
  std::stop_source end_capture_;
  std::optional<ErrorCode> no_frames_since_;  ///< what for; the capture thread's, as the next
  bool damage_is_said_ = false, has_begun_ = false;
  bool has_all_frames_ = false;  // that --frames asks for
};

}  // namespace

Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          flow::Mailbox<EncoderSettings>& rates, const std::stop_token& stop,
                          Heartbeat& heartbeat, CaptureThread& capture) {
  const auto camera = [&] {
    const auto activity = heartbeat.doing(fmt::format("reading the scene file {}", settings.scene),
                                          "mend that file or start without --scene");
    return camera_in_scene(settings);
  }();
  if (!camera) return fail(camera.error());
  const std::optional<Instant> begin = beginning(settings);
  auto source = open_source_to_play(settings, begin, stop, heartbeat, capture);
  if (!source) return fail(source.error());
  heartbeat.enter(Stage::kPreparing);
  const auto give_up = [&](const Error& why) {
    close_source(capture, std::move(*source), heartbeat);
    return fail(why);
  };
  auto encoding = [&] {
    const auto activity = heartbeat.doing("preparing to fill holes and to encode",
                                          "start it with --compute cpu, which needs no graphics driver");
    return FrameEncoding::open((*source)->description(), *camera ? &**camera : nullptr, settings);
  }();
  if (!encoding) return give_up(encoding.error());
  auto server = wire::FrameServer::open(listening, encoding->description(),
                                        [&settings](const std::string& sentence, bool is_warning) {
                                          spdlog::log(is_warning ? spdlog::level::warn : spdlog::level::info,
                                                      "{}: {}", settings.name, sentence);
                                        });
  if (!server) return give_up(server.error());
  auto recording = [&] {
    const auto activity = heartbeat.doing(fmt::format("creating the recording {}", settings.record),
                                          "its disk does not answer: record to another one");
    return begin_recording(settings, (*source)->description());
  }();
  if (!recording) return give_up(recording.error());
  spdlog::info("{}: {}x{} {}, depth {} at {}, on {}", settings.name, encoding->description().model.width,
               encoding->description().model.height,
               encoding->description().has_color ? "depth and colour" : "depth only", settings.codec,
               in_words(settings.rates), listening.address());
  Pipeline pipeline(settings, begin, std::move(*source), std::move(*recording), std::move(*encoding),
                    std::move(*server), rates, heartbeat, capture);
  auto ran = pipeline.run(stop);
  pipeline.finish_recording();
  return ran;
}

}  // namespace copresence::server
