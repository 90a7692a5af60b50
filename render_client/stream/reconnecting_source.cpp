#include "render_client/stream/reconnecting_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/flow/waiting.h"
#include "common/wire/message.h"

namespace copresence::stream {
namespace {

using std::chrono::steady_clock;
using Topic = wire::LimitedLog::Topic;
using Severity = wire::LimitedLog::Severity;

/// While no frames arrive, the log's held-back lines are written at this interval.
constexpr std::chrono::milliseconds kCatchUpEvery{1000};

}  // namespace

ReconnectingSource::ReconnectingSource(std::string address, std::size_t slot, CameraStates& states,
                                       wire::LimitedLog& log, Connect connect, Begin begin)
    : address_(std::move(address)),
      slot_(slot),
      states_(states),
      log_(log),
      connect_(std::move(connect)),
      begin_(std::move(begin)) {}

Result<wire::ReceivedFrame> ReconnectingSource::next(std::stop_token stop, std::optional<Instant> latest) {
  while (!stop.stop_requested()) {
    Result<void> connection;
    if (!source_) connection = connect(stop);
    const Instant wake_at = steady_clock::now() + kCatchUpEvery;
    const Instant until = latest ? std::min(*latest, wake_at) : wake_at;
    auto received = connection ? source_->next(stop, until) : fail(connection.error());
    const Instant now = steady_clock::now();
    if (source_) log_.catch_up(now);
    if (received) return received;
    if (stop.stop_requested()) break;
    if (received.error().code != ErrorCode::kTimeout || now < until || !source_) {
      const auto pause = failed(received.error());
      log_.catch_up(steady_clock::now());
      if (!pause) return fail(received.error());
      wait_for(*pause, stop);
    }
    if (latest && steady_clock::now() >= *latest)
      return fail(ErrorCode::kTimeout, fmt::format("{}: no frame has come", address_));
  }
  return fail(ErrorCode::kUnavailable, fmt::format("{}: asked to stop", address_));
}

Result<void> ReconnectingSource::connect(const std::stop_token& stop) {
  auto source = connect_(stop);
  if (!source) return fail(source.error());
  source_ = std::move(*source);
  camera_ = source_->description().camera;
  states_.connected(slot_, camera_);
  const auto remark = begin_(source_->description());
  if (!remark) return fail(with_address(remark.error()));
  availability_.connected();
  say(Topic::kConnection, Severity::kInfo, fmt::format("{}: connected to camera \"{}\"", address_, camera_));
  if (!remark->empty()) say(Topic::kSetup, Severity::kWarning, fmt::format("{}: {}", address_, *remark));
  source_->on_status([this](const std::string& status) { status_changed(status); });
  return {};
}

void ReconnectingSource::decoded() {
  availability_.decoded(steady_clock::now());
  publish();
}

void ReconnectingSource::undecodable(const std::string& why) {
  source_->request_keyframe();
  availability_.undecodable(fmt::format("{}: its frames cannot be decoded: {}", address_, why),
                            steady_clock::now());
  publish();
}

std::optional<Duration> ReconnectingSource::failed(const Error& error) {
  const bool was_connected = source_ != nullptr;
  const bool server_ended_it = was_connected && error.code == ErrorCode::kEndOfStream;
  if (server_ended_it && wire::EndOfStream{error.what}.is_final()) states_.over(slot_, error.what);
  const Error why = server_ended_it ? with_address(error) : error;
  source_.reset();
  const auto pause = availability_.failed(why, steady_clock::now());
  publish();
  log_failure(why, was_connected);
  return pause;
}

void ReconnectingSource::status_changed(const std::string& status) {
  states_.status(slot_, status);
  if (status.empty()) {
    say(Topic::kNotice, Severity::kInfo, fmt::format("{}: camera \"{}\" is back", address_, camera_));
  } else {
    say(Topic::kNotice, Severity::kWarning, fmt::format("{}: {}", address_, status));
  }
  if (on_status_) on_status_(status);
}

void ReconnectingSource::publish() {
  const Availability before = published_, now = availability_.availability();
  const bool is_out = is_left_out(now);
  const std::string reason = is_out ? availability_.reason() : std::string();
  if (now == before && reason == published_reason_) return;
  published_ = now;
  published_reason_ = reason;
  states_.availability(slot_, now, reason);
  // If all cameras are refused, the program ends and prints the reasons itself.
  if (is_out && !states_.all_refused()) {
    say(Topic::kAvailability, Severity::kWarning, reason + "; this camera is left out of the view");
  } else if (is_left_out(before) && now == Availability::kShown) {
    say(Topic::kAvailability, Severity::kInfo,
        fmt::format("{}: camera \"{}\" is in the view again", address_, camera_));
  }
}

void ReconnectingSource::log_failure(const Error& why, bool was_connected) {
  // The log already states why a camera is left out.
  const bool is_logged = is_left_out(published_);
  if (was_connected) {
    if (!is_logged) say(Topic::kConnection, Severity::kWarning, why.what);
  } else if (const auto line = states_.not_connected(slot_, why.what, steady_clock::now());
             line && !is_logged) {
    say(Topic::kConnection, Severity::kInfo, *line);
  }
}

void ReconnectingSource::say(Topic topic, Severity severity, std::string_view text) {
  log_.say(topic, severity, text, steady_clock::now());
}

Error ReconnectingSource::with_address(const Error& error) const {
  return {error.code, fmt::format("{}: {}", address_, error.what)};
}

}  // namespace copresence::stream
