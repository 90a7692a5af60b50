#include "render_client/shown_cameras.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace copresence::client {
namespace {

/// Once every camera has sent a frame, views wait at most this long for the first match of colours.
constexpr std::chrono::milliseconds kLongestColorWait{10'000};
/// A camera whose newest frame is older than this is ignored when the skew is computed.
constexpr std::chrono::milliseconds kStopped{500};
/// A camera's frame shows the moving surfaces of another camera only if it is at most this many of
/// its own frame periods older.
constexpr double kMostPeriodsApart = 2.5;

Duration seconds(double value) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(value));
}

}  // namespace

renderer::CameraView camera_view(const CameraFrame& frame, std::uint64_t version,
                                 const color_matching::ColorCorrection& found) {
  const CameraSetup& setup = *frame.setup;
  renderer::CameraView view;
  view.frame = &frame.frame;
  view.version = version;
  view.model = setup.model;
  view.unit = setup.unit;
  view.noise = setup.noise;
  view.world_from_camera = frame.pose();
  view.color_correction = setup.color_correction.value_or(found);
  view.calibration_error_m = setup.calibration_error_m;
  return view;
}

ShownCameras::ShownCameras(const ClientSettings& settings, const std::vector<std::string>& addresses,
                           const stream::CameraStates& states,
                           std::deque<statistics::CameraStatistics>& statistics,
                           color_matching::LiveColorMatching& colors)
    : settings_(settings),
      addresses_(addresses),
      states_(states),
      statistics_(statistics),
      colors_(colors),
      frames_(addresses.size(), settings.sync,
              [this](std::size_t camera) { statistics_[camera].not_displayed(); }),
      stale_(addresses.size(), seconds(settings.stale_s)),
      moving_surfaces_(addresses.size()),
      cameras_(addresses.size()) {}

std::vector<ShownCameras::Arrival> ShownCameras::take(flow::Mailboxes<CameraFrame>& mailboxes, Instant now) {
  frames_.gather(mailboxes, now);
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    auto frame = frames_.take(i);
    if (!states_.left_out(i).empty()) {
      if (frame) statistics_[i].not_displayed();
      remove(i);
    } else if (frame) {
      show(i, std::move(*frame), now);
      const CameraFrame& newest = *cameras_[i].newest;
      arrivals.push_back({i, newest.arrived_at, newest.pose(), newest.setup->model});
    }
  }
  note_stale_cameras(now);
  return arrivals;
}

void ShownCameras::leave_out_moving_surfaces(std::size_t index, CameraFrame& frame, Instant now) {
  if (!frame.setup->has_pose || frame.moving_blocks.empty()) return;
  std::vector<std::optional<moving_surfaces::CameraMotion>> cameras(cameras_.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const CameraFrame* const shown = i == index ? &frame : cameras_[i].newest.get();
    if (!shown || !shown->setup->has_pose) continue;
    if (i != index) {
      const double period_s = 1 / shown->stream->frames_per_second;
      const bool is_recent = frame.captured_at - shown->captured_at <= seconds(kMostPeriodsApart * period_s);
      if (!is_recent || moving_surfaces::capture_together(frame.captured_at, shown->captured_at, period_s))
        continue;
      if (stale_.opacity(i, now) < 1) continue;
    }
    cameras[i] = {camera_view(*shown, 0, color_matching::ColorCorrection::Identity()), &shown->moving_blocks};
  }
  moving_surfaces_.leave_out(frame.frame, index, cameras);
}

void ShownCameras::show(std::size_t index, CameraFrame frame, Instant now) {
  leave_out_moving_surfaces(index, frame, now);
  Camera& camera = cameras_[index];
  if (camera.is_fresh) statistics_[index].not_displayed();
  camera.newest = std::make_shared<const CameraFrame>(std::move(frame));
  camera.is_fresh = true;
  camera.version = ++versions_;
  if (camera.newest->remembered != camera.remembered) {
    camera.remembered = camera.newest->remembered;
    camera.remembered_version = ++versions_;
  }
  const CameraFrame& newest = *camera.newest;
  if (!camera.said_no_pose && !newest.setup->has_pose) {
    spdlog::info("{}: camera \"{}\" has no pose; it stands at the world's origin", addresses_[index],
                 newest.stream->camera);
    camera.said_no_pose = true;
  }
  stale_.frame_arrived(index, seconds(1 / newest.stream->frames_per_second), newest.arrived_at);
  if (settings_.match_colors && newest.setup->has_pose) colors_.show(index, camera.newest);
}

void ShownCameras::remove(std::size_t index) {
  Camera& camera = cameras_[index];
  if (!camera.newest) return;
  if (std::exchange(camera.is_fresh, false)) statistics_[index].not_displayed();
  camera.newest.reset();
  camera.remembered.reset();
  colors_.forget(index);
  was_removed_ = true;
}

void ShownCameras::note_stale_cameras(Instant now) {
  for (const auto& [camera, change, worth_saying] : stale_.changes(now)) {
    const bool is_stale = change == pacing::StaleCameras::Change::kStale;
    if (is_stale) {
      statistics_[camera].stale();
      colors_.forget(camera);  // The light may have changed since its last frame.
    }
    if (!worth_saying || !states_.left_out(camera).empty()) continue;
    const std::string name = states_.name(camera);
    if (is_stale) {
      spdlog::warn("{}: camera \"{}\" sends no pictures; its last one fades from the view until some come",
                   addresses_[camera], name);
    } else {
      spdlog::info("{}: camera \"{}\" sends pictures again and is back in the view", addresses_[camera],
                   name);
    }
  }
}

std::vector<renderer::CameraView> ShownCameras::views(Instant now) const {
  std::vector<renderer::CameraView> views;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    if (!camera.newest) continue;
    views.push_back(camera_view(*camera.newest, camera.version, colors_.correction(i)));
    views.back().opacity = stale_.opacity(i, now);
  }
  // Remembered backgrounds come last, so that the newest frames keep their places in the renderer.
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    if (!camera.newest || !camera.remembered) continue;
    views.push_back(camera_view(*camera.newest, camera.remembered_version, colors_.correction(i)));
    views.back().frame = camera.remembered.get();
    views.back().opacity = stale_.opacity(i, now);
    views.back().is_remembered = true;
  }
  if (!corrects_colors_) {
    for (renderer::CameraView& view : views) view.color_correction.setIdentity();
  }
  return views;
}

std::vector<std::size_t> ShownCameras::cameras_of_views() const {
  std::vector<std::size_t> cameras;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].newest) cameras.push_back(i);
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].newest && cameras_[i].remembered) cameras.push_back(i);
  }
  return cameras;
}

float ShownCameras::opacity(std::size_t camera, Instant now) const {
  return cameras_[camera].newest ? stale_.opacity(camera, now) : 0;
}

bool ShownCameras::have_changed() const {
  return was_removed_ ||
         std::any_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.is_fresh; });
}

bool ShownCameras::have_waiting() const {
  return frames_.has_waiting() ||
         std::any_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.is_fresh; });
}

std::optional<Instant> ShownCameras::next_fading_view() const {
  return last_view_at_ ? stale_.next_view(*last_view_at_) : std::nullopt;
}

void ShownCameras::displayed(Instant begin, Instant end) {
  last_view_at_ = begin;
  was_removed_ = false;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (!std::exchange(camera.is_fresh, false)) continue;
    const CameraFrame& frame = *camera.newest;
    statistics_[i].displayed(frame.frame.metadata.sequence,
                             frame.times_believed ? std::optional(end - frame.captured_at) : std::nullopt);
  }
}

bool ShownCameras::are_complete() const {
  std::size_t shown = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].newest) {
      ++shown;
    } else if (states_.left_out(i).empty()) {
      return false;
    }
  }
  return shown > 0;
}

std::vector<std::size_t> ShownCameras::cameras_to_match() const {
  std::vector<std::size_t> cameras;
  for (std::size_t i = 0; settings_.match_colors && i < cameras_.size(); ++i) {
    const CameraFrame* const newest = cameras_[i].newest.get();
    if (newest && newest->setup->has_pose && newest->stream->has_color && !newest->setup->color_correction)
      cameras.push_back(i);
  }
  return cameras.size() < 2 ? std::vector<std::size_t>{} : cameras;
}

bool ShownCameras::colors_are_settled(Instant now) {
  if (colors_settled_) return true;
  const std::vector<std::size_t> matched = cameras_to_match();
  if (!complete_since_) complete_since_ = now;
  using FirstMatch = color_matching::LiveColorMatching::FirstMatch;
  const FirstMatch first = matched.empty() ? FirstMatch::kFound : colors_.first_match(matched);
  if (first == FirstMatch::kAwaited && now < *complete_since_ + kLongestColorWait) return false;
  colors_settled_ = true;
  if (first == FirstMatch::kFound) return true;
  for (std::size_t i : matched) {
    if (colors_.is_matched(i)) continue;
    spdlog::info(
        "{}: the colours of camera \"{}\" are not matched, because its view overlaps too little with those "
        "of matched cameras",
        addresses_[i], cameras_[i].newest->stream->camera);
  }
  return true;
}

std::optional<Duration> ShownCameras::skew(Instant now) const {
  std::optional<Instant> earliest, latest;
  int cameras = 0;
  for (const Camera& camera : cameras_) {
    if (!camera.newest || now - camera.newest->captured_at > kStopped) continue;
    const Instant captured_at = camera.newest->captured_at;
    ++cameras;
    earliest = std::min(earliest.value_or(captured_at), captured_at);
    latest = std::max(latest.value_or(captured_at), captured_at);
  }
  return cameras < 2 ? std::nullopt : std::optional(*latest - *earliest);
}

}  // namespace copresence::client
