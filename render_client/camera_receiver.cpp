#include "render_client/camera_receiver.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "render_client/stream/frame_times.h"

namespace copresence::client {
namespace {

using std::chrono::steady_clock;
using Severity = wire::LimitedLog::Severity;
using Topic = wire::LimitedLog::Topic;

/// Capture times go back by more than this only if a replay has jumped.
constexpr std::chrono::seconds kJump{1};

void write_line(Severity severity, const std::string& line) {
  spdlog::log(severity == Severity::kInfo ? spdlog::level::info : spdlog::level::warn, "{}", line);
}

}  // namespace

CameraReceiver::CameraReceiver(Camera camera, const scene::Scene* scene, bool remembers,
                               flow::Mailboxes<CameraFrame>& mailboxes,
                               statistics::CameraStatistics& statistics, stream::CameraStates& states,
                               SessionRecorder* recorder)
    : camera_(std::move(camera)),
      scene_(scene),
      mailboxes_(mailboxes),
      statistics_(statistics),
      recorder_(recorder),
      log_(write_line),
      source_(camera_.address, camera_.slot, states, log_, camera_.connect,
              [this](const StreamDescription& description) { return begin(description); }) {
  if (remembers) background_.emplace();
}

void CameraReceiver::run(const std::stop_token& stop) {
  while (auto received = source_.next(stop)) take(std::move(*received));
  log_.finish();
}

Result<std::string> CameraReceiver::begin(const StreamDescription& description) {
  auto decoding = decoding::FrameDecoding::open(description);
  if (!decoding) return fail(decoding.error());
  decoding_.emplace(std::move(*decoding));
  statistics_.connected();
  description_ = std::make_shared<const StreamDescription>(description);
  setup_ = std::make_shared<const CameraSetup>(resolve_setup(description, scene_));
  conditioner_.begin(*setup_, scene_ ? scene_->clip : std::nullopt);
  if (background_) background_->begin(setup_->unit, setup_->noise);
  motion_.begin(setup_->unit, setup_->noise);
  return setup_->remark;
}

void CameraReceiver::take(wire::ReceivedFrame received) {
  const EncodedFrame& encoded = received.frame;
  statistics_.received(received.counters, encoded.depth.size() + encoded.color.size(), received.received_at);

  decoding::FrameDecoding::Durations durations;
  auto frame = decoding_->decode(encoded, durations);
  if (!frame) {
    statistics_.not_decoded();
    spdlog::debug("{}: {}", camera_.address, frame.error().what);
    return source_.undecodable(frame.error().what);
  }
  statistics_.decoded();
  if (decoding_->repeat_color(*frame)) statistics_.color_repeated();
  source_.decoded();

  const wire::ClockOffset clock = source_.clock();
  const stream::FrameTimes times =
      stream::frame_times(frame->metadata.captured_at, received.sent_at, received.received_at, clock);
  statistics_.clock(clock.offset, clock.uncertainty);
  statistics_.timed(times.wire, encoded.durations);
  statistics_.stage(statistics::Stage::kVideoDecode, durations.video_decode);
  statistics_.stage(statistics::Stage::kDepthDecode, durations.depth_decode);
  if (!times.are_believed()) {
    log_.say(Topic::kTimes, Severity::kWarning,
             fmt::format("{}: the times of its frames are implausible; arrival times are used as capture "
                         "times",
                         camera_.address),
             steady_clock::now());
  }

  conditioner_.apply(*frame);
  // What the camera saw later must not be remembered after a jump back.
  const bool has_jumped_back = times.captured_at < newest_at_ - kJump;
  newest_at_ = times.captured_at;
  if (background_) {
    if (has_jumped_back) background_->begin(setup_->unit, setup_->noise);
    background_->learn(*frame);
  }
  const moving_surfaces::MovingBlocks& moving_blocks = motion_.detect(frame->depth);
  CameraFrame ready{std::move(*frame),
                    times.captured_at,
                    camera_.now(),
                    description_,
                    setup_,
                    times.are_believed(),
                    background_ ? background_->covered() : nullptr,
                    moving_blocks};
  if (mailboxes_.put(camera_.slot, std::move(ready))) statistics_.not_displayed();
  if (recorder_ &&
      recorder_->offer(camera_.slot, description_, std::move(received.frame), times.captured_at)) {
    source_.request_keyframe();
  }
}

}  // namespace copresence::client
