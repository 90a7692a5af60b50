#include "render_client/stream/camera_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace copresence::stream {
namespace {

constexpr std::chrono::seconds kSayAgainAfter{10}, kThenEvery{60};

/// Removes the address from the beginning of a sentence.
std::string_view without_address(std::string_view sentence, std::string_view address) {
  if (!sentence.starts_with(address)) return sentence;
  const std::string_view rest = sentence.substr(address.size());
  return rest.starts_with(": ") ? rest.substr(2) : sentence;
}

}  // namespace

CameraStates::CameraStates(const std::vector<ListedCamera>& cameras, std::function<void()> on_all_refused)
    : on_all_refused_(std::move(on_all_refused)) {
  for (const ListedCamera& camera : cameras) {
    cameras_.emplace_back();
    cameras_.back().address = camera.address;
    cameras_.back().name = camera.name;
  }
}

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
  now.address = of.address;
  now.name = std::move(name);
  now.is_connected = true;
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

std::string CameraStates::name_and_address(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return name_and_address(cameras_[camera]);
}

std::string CameraStates::name_and_address(const Camera& camera) {
  return camera.name.empty() ? camera.address : fmt::format("{} at {}", camera.name, camera.address);
}

std::string CameraStates::why_no_frames(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return why_no_frames(cameras_[camera]);
}

std::string CameraStates::why_no_frames(const Camera& camera) {
  const std::string name = name_and_address(camera);
  if (!camera.left_out.empty())
    return fmt::format("{} is left out of the view: {}", name,
                       without_address(camera.left_out, camera.address));
  if (!camera.over.empty()) return fmt::format("{}: {}", name, without_address(camera.over, camera.address));
  if (camera.is_connected && !camera.status.empty()) return fmt::format("{}: {}", name, camera.status);
  if (camera.is_connected)
    return camera.availability == Availability::kShown
               ? ""
               : name + " is connected; waiting for its first picture";
  if (camera.tries == 0) return "connecting to " + name;
  return fmt::format("waiting for {}, {} try: {}", name, ordinal(camera.tries),
                     without_address(camera.why, camera.address));
}

std::string CameraStates::title(std::string_view program) const {
  std::lock_guard lock(mutex_);
  std::string first;
  int more = 0;
  for (const Camera& camera : cameras_) {
    std::string what = why_no_frames(camera);
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
  static constexpr std::array kWords = {"first", "second",  "third",  "fourth", "fifth",
                                        "sixth", "seventh", "eighth", "ninth",  "tenth"};
  if (number >= 1 && number <= 10) return kWords[static_cast<std::size_t>(number) - 1];
  const int last = number % 10, last_two = number % 100;
  const bool is_teen = last_two >= 11 && last_two <= 13;
  const char* const ending = is_teen ? "th" : last == 1 ? "st" : last == 2 ? "nd" : last == 3 ? "rd" : "th";
  return fmt::format("{}{}", number, ending);
}

}  // namespace copresence::stream
