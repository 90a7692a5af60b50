#include "capture_server/capture_stage.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "capture_server/sensor/reconnecting_source.h"
#include "capture_server/sensor/source.h"
#include "common/flow/thread_priority.h"
#include "common/flow/waiting.h"

namespace copresence::server {
namespace {

constexpr std::chrono::milliseconds kBetweenTries = sensor::ReconnectingSource::kBetweenTries;
constexpr std::chrono::seconds kBetweenWarnings{10};

/// True if it helps to open the source again. After a crash, "not found" means that the camera was
/// unplugged, and "unavailable" that its driver still holds it. Any other error is final, and so is
/// every error of a recording.
bool may_come_back(const Error& error, const ServerSettings& settings, const Heartbeat& heartbeat) {
  return heartbeat.predecessor().existed && !sensor::is_recording(settings.source) &&
         (error.code == ErrorCode::kNotFound || error.code == ErrorCode::kUnavailable);
}

}  // namespace

std::optional<Instant> first_frame_due(const ServerSettings& settings) {
  if (!settings.start_at) return std::nullopt;
  using Seconds = std::chrono::duration<double>;
  const Seconds ahead = Seconds(*settings.start_at) - std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<Duration>(ahead);
}

Result<std::unique_ptr<sensor::FrameSource>> open_source(const ServerSettings& settings,
                                                         std::optional<Instant> begin,
                                                         const std::stop_token& stop, Heartbeat& heartbeat,
                                                         CaptureThread& capture) {
  heartbeat.enter(Stage::kOpening);
  // A camera's thread keeps its priority, because it has to keep up with the camera.
  if (sensor::is_recording(settings.source)) capture.run([] { flow::lower_priority(kStepsBelowRendering); });
  const sensor::SourceSettings of_source{
      .pace = settings.pace, .loop = settings.loop, .begin = begin, .controls = settings.controls};
  std::optional<Instant> warned_at;
  while (true) {
    heartbeat.main().open();
    Result<std::unique_ptr<sensor::FrameSource>> source;
    capture.run([&] { source = sensor::open_source(settings.source, of_source); });
    if (source || !may_come_back(source.error(), settings, heartbeat)) return source;
    const Instant now = std::chrono::steady_clock::now();
    if (!warned_at || now >= *warned_at + kBetweenWarnings) {
      warned_at = now;
      spdlog::warn("{}; waiting for it", source.error().what);
    }
    wait_for(kBetweenTries, stop);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
  }
}

void close_source(CaptureThread& capture, std::unique_ptr<sensor::FrameSource> source, Heartbeat& heartbeat) {
  heartbeat.main().open();
  capture.run([&] { source.reset(); });
  heartbeat.main().rest();
}

CaptureStage::CaptureStage(const ServerSettings& settings, std::optional<Instant> begin,
                           sensor::FrameSource& source, RecordingThread* recording, wire::FrameServer& server,
                           Heartbeat& heartbeat)
    : settings_(settings),
      begin_(begin),
      source_(source),
      recording_(recording),
      server_(server),
      heartbeat_(heartbeat) {}

Result<void> CaptureStage::run(flow::Mailbox<CapturedFrame>& captured, const std::stop_token& stop,
                               Pulse& pulse) {
  const bool keeps_every_frame = settings_.keeps_every_frame();
  wait_for_begin(stop, pulse);
  while (!stop.stop_requested()) {
    may_open_again() ? pulse.open() : pulse.beat();
    auto frame = source_.next(stop);
    pulse.beat();
    if (!frame) {
      if (frame.error().code == ErrorCode::kEndOfStream) return {};
      if (!may_continue(frame.error())) return fail(frame.error());
      log_interruption(frame.error());
      continue;
    }
    log_resumption();
    has_begun_ = true;
    const std::uint64_t sequence = frame->metadata.sequence;
    heartbeat_.captured(sequence);
    // The thread may wait long for the disk and the encoder, since no frame may be dropped.
    if (keeps_every_frame) pulse.rest();
    if (recording_) recording_->offer(*frame, keeps_every_frame, stop);
    if (keeps_every_frame) captured.wait_until_taken(stop);
    captured.put({std::move(*frame), source_.counters()});
    if (settings_.frames && sequence >= *settings_.frames) {
      has_all_frames_ = true;
      return {};
    }
  }
  return {};
}

// True if the next call of the source's next() may take as long as opening a camera.
bool CaptureStage::may_open_again() const {
  return !sensor::is_recording(settings_.source) && (!has_begun_ || interrupted_by_);
}

// Waits until shortly before the first frame is due. The source waits for the exact instant.
void CaptureStage::wait_for_begin(const std::stop_token& stop, Pulse& pulse) const {
  constexpr std::chrono::milliseconds kShortly{200};
  if (!begin_) return;
  const std::chrono::duration<double> ahead = *begin_ - std::chrono::steady_clock::now();
  if (ahead > kShortly) spdlog::info("{}: begins in {:.1f} s", settings_.name, ahead.count());
  while (!stop.stop_requested() && std::chrono::steady_clock::now() + kShortly < *begin_) {
    pulse.beat();
    wait_for(kShortly, stop);
  }
}

void CaptureStage::log_missing_pictures() const {
  const sensor::SourceCounters pictures = source_.counters();
  if (pictures.damaged) {
    spdlog::warn("{}: {} depth or colour pictures were damaged{}", settings_.name, pictures.damaged,
                 sensor::is_recording(settings_.source) ? " or are missing from the recording" : "");
  }
  if (pictures.late) {
    spdlog::info(
        "{}: {} depth or colour pictures came too late and were skipped: this machine{} was too busy to "
        "take them before the next ones",
        settings_.name, pictures.late, settings_.source.starts_with("openni:") ? " or its USB" : "");
  }
  if (pictures.projector_off) {
    spdlog::info("{}: {} depth pictures were taken outside its projector's time slot and left out",
                 settings_.name, pictures.projector_off);
  }
}

// True if the source may deliver frames after this error. A camera may be plugged in again, and a
// damaged recording may have intact parts. Any other error is final.
bool CaptureStage::may_continue(const Error& error) const {
  if (sensor::is_recording(settings_.source))
    return error.code == ErrorCode::kCorrupt || error.code == ErrorCode::kUnavailable;
  return error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kTimeout;
}

void CaptureStage::log_interruption(const Error& why) {
  if (std::exchange(interrupted_by_, why.code)) return;
  const bool is_damaged = why.code == ErrorCode::kCorrupt;
  // Damage is logged only once, because a replay with --loop meets it again and again.
  if (!is_damaged || !std::exchange(damage_is_logged_, true))
    spdlog::warn("{}; {}", why.what, is_damaged ? "playing on" : "waiting for it");
  server_.set_camera_status(why.what);
}

void CaptureStage::log_resumption() {
  const auto reason = std::exchange(interrupted_by_, std::nullopt);
  if (!reason) return;
  if (*reason != ErrorCode::kCorrupt) spdlog::info("{}: the camera is back", settings_.name);
  server_.set_camera_status({});
}

}  // namespace copresence::server
