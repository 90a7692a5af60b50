#include "capture_server/running_settings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <chrono>
#include <thread>
#include <utility>

namespace copresence::server {
namespace {

/// Editors write a file in pieces, or empty it first. Only content that two readings in a row agree
/// on is used.
constexpr std::chrono::milliseconds kBetweenLooks{50};
constexpr int kMostLooks = 5;

constexpr std::array kOfEncoder = {"depth-qp", "depth-kbps", "color-kbps"};

bool is_of_encoder(const std::string& key) {
  for (const char* of_encoder : kOfEncoder) {
    if (key == of_encoder) return true;
  }
  return false;
}

std::string shown(const std::string& text) {
  return text.empty() ? "none" : text;
}

}  // namespace

SettingsChange change(const ServerSettings& running, const ServerSettings& wanted) {
  SettingsChange change{running, {}, {}};
  change.settings.encoder = wanted.encoder;
  for (const auto& [key, text] : wanted.texts) {
    std::string& was = change.settings.texts[key];
    if (was == text) continue;
    const std::string words = fmt::format("{} {} -> {}", key, shown(was), shown(text));
    if (is_of_encoder(key)) {
      change.at_once.push_back(words);
      was = text;
    } else {
      change.after_a_restart.push_back(words);
    }
  }
  return change;
}

RunningSettings::RunningSettings(int argc, const char* const* argv, ServerSettings begun_with)
    : file_(begun_with.config), argc_(argc), argv_(argv), now_(std::move(begun_with)) {}

Result<ServerSettings> RunningSettings::read_settled() const {
  auto read = server::read_again(argc_, argv_);
  for (int look = 1; look < kMostLooks; ++look) {
    std::this_thread::sleep_for(kBetweenLooks);
    auto again = server::read_again(argc_, argv_);
    const bool is_settled = read && again ? read->texts == again->texts
                                          : !read && !again && read.error().what == again.error().what;
    read = std::move(again);
    if (is_settled) break;
  }
  return read;
}

void RunningSettings::read_again() {
  const auto wanted = read_settled();
  if (!wanted) {
    spdlog::warn("{}; everything goes on as before", wanted.error().what);
    return;
  }
  SettingsChange changed = change(now(), *wanted);
  if (!changed.at_once.empty()) {
    spdlog::info("{} read again: {}", file_, fmt::join(changed.at_once, ", "));
    encoder_changes_.put(changed.settings.encoder);
  }
  if (!changed.after_a_restart.empty()) {
    spdlog::warn("{} read again: a restart of the server is needed for {}", file_,
                 fmt::join(changed.after_a_restart, ", "));
  }
  if (changed.at_once.empty() && changed.after_a_restart.empty()) {
    spdlog::info("{} read again: nothing has changed", file_);
  }
  const std::lock_guard lock(mutex_);
  now_ = std::move(changed.settings);
}

ServerSettings RunningSettings::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

}  // namespace copresence::server
