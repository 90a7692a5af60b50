#include "web_gateway/camera_feed.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/flow/waiting.h"

namespace copresence::gateway {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using Topic = wire::LimitedLog::Topic;
using Severity = wire::LimitedLog::Severity;

constexpr milliseconds kConnectTimeout{2000};
// The pause before the next try doubles with every failure. It becomes short again after a
// connection that lasted for kSteady.
constexpr milliseconds kFirstPause{50}, kLongestPause{500};
constexpr std::chrono::seconds kSteady{2};
// While no frame comes, lines that the log held back are written at this interval.
constexpr milliseconds kCatchUpEvery{1000};
// Limit of frames that were passed on and not taken, about 2 s.
constexpr int kMostWaiting = 64;

void write_line(Severity severity, const std::string& line) {
  spdlog::log(severity == Severity::kInfo ? spdlog::level::info : spdlog::level::warn, "{}", line);
}

}  // namespace

CameraFeed::CameraFeed(std::uint8_t index, std::string address, const tls::RoomKey* key, OnEvent on_event)
    : index_(index),
      address_(std::move(address)),
      key_(key),
      on_event_(std::move(on_event)),
      log_(write_line) {}

Result<void> CameraFeed::run(const std::stop_token& stop) {
  milliseconds pause = kFirstPause;
  while (!stop.stop_requested()) {
    auto client = wire::FrameClient::connect(address_, kConnectTimeout, stop, key_);
    const Instant began_at = steady_clock::now();
    const Error why = client ? receive(*client, stop) : client.error();
    if (stop.stop_requested()) break;
    report_failure(why, client.has_value());
    if (why.code == ErrorCode::kRefused) return fail(why);
    if (client && steady_clock::now() - began_at >= kSteady) pause = kFirstPause;
    wait_for(pause, stop);
    pause = std::min(2 * pause, kLongestPause);
  }
  log_.finish();
  return {};
}

Error CameraFeed::receive(wire::FrameClient& client, const std::stop_token& stop) {
  const std::string& camera = client.description().camera;
  log_.say(Topic::kConnection, Severity::kInfo,
           fmt::format("{}: connected to camera \"{}\"", address_, camera), steady_clock::now());
  client.on_camera_status([&](const std::string& status) {
    log_.say(Topic::kNotice, status.empty() ? Severity::kInfo : Severity::kWarning,
             status.empty() ? fmt::format("{}: camera \"{}\" is back", address_, camera)
                            : fmt::format("{}: {}", address_, status),
             steady_clock::now());
    on_event_(forwarding::StatusChanged{status});
  });
  {
    const std::lock_guard lock(mutex_);
    client_ = &client;
  }
  on_event_(forwarding::Connected{client.description(), client.clock()});
  awaits_keyframe_ = false;
  while (true) {
    const Instant until = steady_clock::now() + kCatchUpEvery;
    auto received = client.receive(stop, until);
    const Instant now = steady_clock::now();
    log_.catch_up(now);
    if (received) {
      pass_on(std::move(*received), client);
    } else if (received.error().code != ErrorCode::kTimeout || now < until) {
      const std::lock_guard lock(mutex_);
      client_ = nullptr;
      return received.error();
    }
  }
}

void CameraFeed::pass_on(wire::ReceivedFrame received, wire::FrameClient& client) {
  if (awaits_keyframe_ && !received.frame.keyframe) return;
  awaits_keyframe_ = waiting_ >= kMostWaiting;
  if (awaits_keyframe_) return client.request_keyframe();
  ++waiting_;
  on_event_(
      forwarding::FrameCame{forwarding::make_forwarded_frame(index_, std::move(received)), client.clock()});
}

void CameraFeed::request_keyframe() {
  const std::lock_guard lock(mutex_);
  if (client_) client_->request_keyframe();
}

void CameraFeed::report_failure(const Error& why, bool was_connected) {
  const bool ended = was_connected && why.code == ErrorCode::kEndOfStream;
  const bool is_final = why.code == ErrorCode::kRefused;
  log_.say(Topic::kConnection, is_final || was_connected ? Severity::kWarning : Severity::kInfo,
           ended ? fmt::format("{}: {}", address_, why.what) : why.what, steady_clock::now());
  on_event_(forwarding::Disconnected{why.what, ended, is_final});
}

}  // namespace copresence::gateway
