#include "render_client/stream/camera_receiver.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "common/flow/waiting.h"
#include "common/wire/message.h"
#include "render_client/stream/frame_times.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using Topic = LimitedLog::Topic;
using Severity = LimitedLog::Severity;

constexpr milliseconds kConnectTimeout{2000};
/// How often a camera without frames is looked after: lines that were held back are said then.
constexpr milliseconds kLookAfter{1000};

void write_line(Severity severity, const std::string& line) {
  spdlog::log(severity == Severity::kInfo ? spdlog::level::info : spdlog::level::warn, "{}", line);
}

}  // namespace

CameraReceiver::CameraReceiver(std::string address, std::size_t slot, const scene::Scene* scene,
                               flow::Mailboxes<Received>& board, CameraStatistics& statistics,
                               CameraStates& states)
    : address_(std::move(address)),
      slot_(slot),
      scene_(scene),
      board_(board),
      statistics_(statistics),
      states_(states),
      log_(write_line) {}

void CameraReceiver::run(std::stop_token stop) {
  while (!stop.stop_requested()) {
    auto client = wire::FrameClient::connect(address_, kConnectTimeout, stop);
    const Error why = client ? receive_from(*client, stop) : client.error();
    if (stop.stop_requested()) break;
    const auto pause = availability_.failed(why, steady_clock::now());
    publish();
    say_failure(why, client.has_value());
    log_.catch_up(steady_clock::now());
    if (!pause) break;
    wait_for(*pause, stop);
  }
  log_.finish();
}

Error CameraReceiver::named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", address_, error.what)};
}

void CameraReceiver::say(Topic topic, Severity severity, std::string_view text) {
  log_.say(topic, severity, text, steady_clock::now());
}

void CameraReceiver::heard(const std::string& notice) {
  states_.notice(slot_, notice);
  if (notice.empty()) {
    say(Topic::kNotice, Severity::kInfo, fmt::format("{}: camera \"{}\" is back", address_, camera_));
  } else {
    say(Topic::kNotice, Severity::kWarning, fmt::format("{}: {}", address_, notice));
  }
}

void CameraReceiver::say_failure(const Error& why, bool was_connected) {
  // That a camera is left out, and why, is said already.
  const bool is_said = is_left_out(published_);
  if (was_connected) {
    if (!is_said) say(Topic::kConnection, Severity::kWarning, why.what);
  } else if (const auto line = states_.not_connected(slot_, why.what, steady_clock::now());
             line && !is_said) {
    say(Topic::kConnection, Severity::kInfo, *line);
  }
}

void CameraReceiver::publish() {
  const Availability before = published_, now = availability_.availability();
  const bool is_out = is_left_out(now);
  const std::string reason = is_out ? availability_.reason() : std::string();
  if (now == before && reason == published_reason_) return;
  published_ = now;
  published_reason_ = reason;
  states_.availability(slot_, now, reason);
  if (is_out && !states_.all_refused()) {  // which ends the program with these sentences
    say(Topic::kAvailability, Severity::kWarning, reason + "; this camera is left out of the view");
  } else if (is_left_out(before) && now == Availability::kShown) {
    say(Topic::kAvailability, Severity::kInfo,
        fmt::format("{}: camera \"{}\" is in the view again", address_, camera_));
  }
}

Error CameraReceiver::receive_from(wire::FrameClient& client, const std::stop_token& stop) {
  Stream stream;
  stream.description = std::make_shared<const StreamDescription>(client.description());
  camera_ = stream.description->camera;
  states_.connected(slot_, camera_);
  auto decoding = FrameDecoding::open(*stream.description);
  if (!decoding) return named(decoding.error());
  availability_.connected();
  statistics_.connected();
  say(Topic::kConnection, Severity::kInfo, fmt::format("{}: connected to camera \"{}\"", address_, camera_));
  stream.setup = std::make_shared<const CameraSetup>(resolve_setup(*stream.description, scene_));
  if (!stream.setup->remark.empty())
    say(Topic::kSetup, Severity::kWarning, fmt::format("{}: {}", address_, stream.setup->remark));
  if (scene_ && scene_->clip) stream.clipper.emplace(*stream.setup, *scene_->clip);
  client.on_camera_status([this](const std::string& notice) { heard(notice); });
  while (true) {
    const Instant look_after_at = steady_clock::now() + kLookAfter;
    auto received = client.receive(stop, look_after_at);
    const Instant now = steady_clock::now();
    log_.catch_up(now);
    if (received) {
      take(client, *decoding, *received, stream);
    } else if (received.error().code != ErrorCode::kTimeout || now < look_after_at) {
      const bool server_says_so = received.error().code == ErrorCode::kEndOfStream;
      if (server_says_so && wire::EndOfStream{received.error().what}.is_final())
        states_.over(slot_, received.error().what);
      return server_says_so ? named(received.error()) : received.error();
    }
  }
}

void CameraReceiver::take(wire::FrameClient& client, FrameDecoding& decoding,
                          const wire::ReceivedFrame& received, const Stream& stream) {
  const EncodedFrame& encoded = received.frame;
  statistics_.received(received.counters, encoded.depth.size() + encoded.color.size(), received.received_at);

  FrameDecoding::Durations durations;
  auto frame = decoding.decode(encoded, durations);
  if (!frame) {
    statistics_.not_decoded();
    client.request_keyframe();
    spdlog::debug("{}: {}", address_, frame.error().what);
    availability_.undecodable(
        fmt::format("{}: its frames cannot be decoded: {}", address_, frame.error().what),
        steady_clock::now());
    return publish();
  }
  statistics_.decoded();
  if (decoding.repeat_color(*frame)) statistics_.color_repeated();
  availability_.decoded(steady_clock::now());
  publish();
  const wire::ClockOffset clock = client.clock();
  const FrameTimes times =
      frame_times(frame->metadata.captured_at, received.sent_at, received.received_at, clock);
  statistics_.clock(clock.offset, clock.uncertainty);
  statistics_.timed(times.wire, encoded.durations);
  statistics_.stage(Stage::kVideoDecode, durations.video_decode);
  statistics_.stage(Stage::kDepthDecode, durations.depth_decode);
  if (!times.are_believed()) {
    say(Topic::kTimes, Severity::kWarning,
        fmt::format(
            "{}: the times of its frames contradict each other; they count as captured when they arrive",
            address_));
  }
  hand_over(std::move(*frame), times.captured_at, times.are_believed(), stream);
}

void CameraReceiver::hand_over(RgbdFrame frame, Instant captured_at, bool times_believed,
                               const Stream& stream) {
  temporal_filter_.apply(frame, stream.description->unit, stream.description->noise);
  if (stream.clipper) stream.clipper->apply(frame);
  smoothing_.smooth(frame.depth, stream.description->unit, stream.description->noise);
  if (board_.put(slot_, {std::move(frame), captured_at, steady_clock::now(), stream.description, stream.setup,
                         times_believed}))
    statistics_.unshown();
}

}  // namespace copresence::client
