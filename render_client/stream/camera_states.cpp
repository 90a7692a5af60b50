#include "render_client/stream/camera_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace copresence::stream {
namespace {

constexpr std::chrono::seconds kSayAgainAfter{10}, kThenEvery{60};

}  // namespace

std::optional<std::string> CameraStates::not_connected(std::size_t camera, std::string why, Instant now) {
  std::lock_guard lock(mutex_);
  Camera& of = cameras_[camera];
  of.is_connected = false;
  of.status.clear();
  of.why = std::move(why);
  ++of.tries;
  if (!of.over.empty()) return std::nullopt;  // Failed tries are expected.
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
  Camera& of = cameras_[camera];
  Camera now;
  now.is_connected = true;
  now.name = std::move(name);
  // A new connection does not change whether views show the camera.
  now.availability = of.availability;
  now.left_out = std::move(of.left_out);
  of = std::move(now);
}

void CameraStates::status(std::size_t camera, std::string text) {
  std::lock_guard lock(mutex_);
  cameras_[camera].status = std::move(text);
}

void CameraStates::over(std::size_t camera, std::string why) {
  std::lock_guard lock(mutex_);
  cameras_[camera].is_connected = false;
  cameras_[camera].over = std::move(why);
}

void CameraStates::availability(std::size_t camera, Availability availability, std::string reason) {
  {
    std::lock_guard lock(mutex_);
    cameras_[camera].availability = availability;
    cameras_[camera].left_out = is_left_out(availability) ? std::move(reason) : std::string();
    const auto is_refused = [](const Camera& of) { return of.availability == Availability::kRefused; };
    if (all_refused_ || !std::all_of(cameras_.begin(), cameras_.end(), is_refused)) return;
    std::string what = cameras_.size() == 1 ? "" : "none of the cameras can be shown: ";
    for (std::size_t i = 0; i < cameras_.size(); ++i) what += (i ? "; " : "") + cameras_[i].left_out;
    all_refused_ = Error{ErrorCode::kRefused, std::move(what)};
  }
  on_all_refused_();
}

bool CameraStates::all_over() const {
  std::lock_guard lock(mutex_);
  const auto is_over = [](const Camera& camera) { return !camera.over.empty(); };
  return std::any_of(cameras_.begin(), cameras_.end(), is_over) &&
         std::all_of(cameras_.begin(), cameras_.end(), [&](const Camera& camera) {
           return is_over(camera) || is_left_out(camera.availability);
         });
}

std::string CameraStates::left_out(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return cameras_[camera].left_out;
}

std::string CameraStates::name(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return cameras_[camera].name;
}

std::optional<Error> CameraStates::all_refused() const {
  std::lock_guard lock(mutex_);
  return all_refused_;
}

std::string CameraStates::awaited(const Camera& camera) {
  if (!camera.left_out.empty()) return camera.left_out;
  if (!camera.over.empty()) return fmt::format("camera \"{}\": {}", camera.name, camera.over);
  if (camera.is_connected) return camera.status;
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

}  // namespace copresence::stream
