#include "render_client/camera_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace copresence::client {
namespace {

constexpr std::chrono::seconds kSayAgainAfter{10}, kThenEvery{60};

}  // namespace

std::optional<std::string> CameraStates::not_connected(std::size_t camera, std::string why, Instant now) {
  std::lock_guard lock(mutex_);
  Camera& of = cameras_[camera];
  of.is_connected = false;
  of.notice.clear();
  of.why = std::move(why);
  ++of.tries;
  if (!of.over.empty()) return std::nullopt;  // that nobody listens any more is no news
  if (!of.next_said_at) {
    of.next_said_at = now + kSayAgainAfter;
    return of.why + "; waiting for it";
  }
  if (now < *of.next_said_at) return std::nullopt;
  of.next_said_at = now + kThenEvery;
  return fmt::format("{}; still waiting for it, {} try", of.why, ordinal(of.tries));
}

void CameraStates::connected(std::size_t camera, std::string name) {
  std::lock_guard lock(mutex_);
  cameras_[camera] = {};
  cameras_[camera].is_connected = true;
  cameras_[camera].name = std::move(name);
}

void CameraStates::notice(std::size_t camera, std::string text) {
  std::lock_guard lock(mutex_);
  cameras_[camera].notice = std::move(text);
}

void CameraStates::over(std::size_t camera, std::string why) {
  std::lock_guard lock(mutex_);
  cameras_[camera].is_connected = false;
  cameras_[camera].over = std::move(why);
}

bool CameraStates::all_over() const {
  std::lock_guard lock(mutex_);
  return std::all_of(cameras_.begin(), cameras_.end(),
                     [](const Camera& camera) { return !camera.over.empty(); });
}

std::string CameraStates::awaited(const Camera& camera) {
  if (!camera.over.empty()) return fmt::format("camera \"{}\": {}", camera.name, camera.over);
  if (camera.is_connected) return camera.notice;
  if (camera.tries == 0) return "connecting";
  return fmt::format("{} try: waiting for {}", ordinal(camera.tries), camera.why);
}

std::string CameraStates::title(std::string_view program) const {
  std::lock_guard lock(mutex_);
  std::string first;
  int more = 0;
  for (const Camera& camera : cameras_) {
    std::string what = awaited(camera);
    if (what.empty()) continue;
    if (first.empty()) {
      first = std::move(what);
    } else {
      ++more;
    }
  }
  if (first.empty()) return std::string(program);
  if (more == 0) return fmt::format("{}: {}", program, first);
  return fmt::format("{}: {} (and {} more)", program, first,
                     more == 1 ? "1 camera" : fmt::format("{} cameras", more));
}

std::string ordinal(int number) {
  const int last = number % 10, last_two = number % 100;
  const bool is_teen = last_two >= 11 && last_two <= 13;
  const char* const ending = is_teen ? "th" : last == 1 ? "st" : last == 2 ? "nd" : last == 3 ? "rd" : "th";
  return fmt::format("{}{}", number, ending);
}

}  // namespace copresence::client
