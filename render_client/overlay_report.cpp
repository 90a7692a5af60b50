#include "render_client/overlay_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "render_client/overlap_agreement.h"

namespace copresence::client {
namespace {

constexpr std::chrono::seconds kFiguresEvery{1}, kMessageFor{5};
constexpr std::size_t kGraphColumns = 40;

double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// Formats an optional number of millimetres.
std::string millimetres(const std::optional<double>& value) {
  return value ? fmt::format("{:.1f}", *value) : "-";
}

double hole_share(const StateImage& state) {
  const auto pixels = state.pixels();
  const auto holes = std::count(pixels.begin(), pixels.end(), DepthState::kHole);
  return pixels.empty() ? 0 : static_cast<double>(holes) / static_cast<double>(pixels.size());
}

/// Returns the dropped frames by cause, such as "window_full 3", or "0".
std::string drops_by_cause(const statistics::CameraStatistics::Snapshot& camera) {
  std::string text;
  for (const auto& [cause, count] : camera.drops) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", cause, count);
  }
  return text.empty() ? "0" : text;
}

}  // namespace

OverlayReport::OverlayReport(const stream::CameraStates& states,
                             const std::deque<statistics::CameraStatistics>& statistics,
                             const ShownCameras& cameras, const scene::Scene* scene)
    : states_(states), statistics_(statistics), shown_(cameras), scene_(scene), cameras_(cameras.size()) {
  figures_.headings = {"camera",  "frames/s", "Mbit/s",   "latency ms", "age ms",
                       "dropped", "holes",    "error mm", "overlap mm"};
  figures_.stages.assign(statistics::kStageNames.begin(), statistics::kStageNames.end());
  figures_.stages.emplace_back("wait and render");
}

void OverlayReport::view_drawn(Instant begin, Instant end,
                               const std::optional<renderer::OriginShares>& shares) {
  ++views_;
  render_time_.add(end - begin);
  shares_ = shares;
}

void OverlayReport::say(std::string message, Instant now) {
  message_ = std::move(message);
  message_until_ = now + kMessageFor;
}

overlay::Content OverlayReport::content(Instant now) {
  if (!figures_at_) figures_at_ = now;
  if (const Duration elapsed = now - *figures_at_; elapsed >= kFiguresEvery) {
    update_figures(now, elapsed);
    figures_at_ = now;
  }
  return {.notices = notices(now), .message = now < message_until_ ? message_ : "", .figures = figures_};
}

std::vector<std::string> OverlayReport::notices(Instant now) const {
  std::vector<std::string> notices;
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    std::string why = states_.why_no_frames(i);
    if (why.empty() && shown_.opacity(i, now) < 1) {
      const auto silence = shown_.newest(i) ? now - shown_.newest(i)->arrived_at : Duration{};
      why = fmt::format("{}: no picture for {} s", states_.name_and_address(i),
                        std::chrono::duration_cast<std::chrono::seconds>(silence).count());
    }
    if (!why.empty()) notices.push_back(std::move(why));
  }
  return notices;
}

void OverlayReport::update_figures(Instant now, Duration elapsed) {
  compare_next_camera();
  figures_.cameras.clear();
  for (std::size_t i = 0; i < cameras_.size(); ++i) figures_.cameras.push_back(camera_line(i, now, elapsed));
  figures_.view = view_rows(now, elapsed);
  views_ = 0;
  render_time_ = {};
}

overlay::CameraLine OverlayReport::camera_line(std::size_t index, Instant now, Duration elapsed) {
  Camera& camera = cameras_[index];
  auto snapshot = statistics_[index].snapshot();
  const auto recent = statistics::interval(camera.before, snapshot, elapsed);
  std::vector<float> stages(recent.stages_ms.begin(), recent.stages_ms.end());
  const float sum = std::accumulate(stages.begin(), stages.end(), 0.0F);
  stages.push_back(std::max(0.0F, static_cast<float>(recent.latency_ms) - sum));
  camera.stages_ms.push_back(std::move(stages));
  if (camera.stages_ms.size() > kGraphColumns) camera.stages_ms.pop_front();

  const std::string name = states_.name(index);
  const scene::Camera* const known = scene_ ? scene_->find(name) : nullptr;
  const CameraFrame* const newest = shown_.newest(index);
  overlay::CameraLine line;
  line.cells = {name.empty() ? states_.name_and_address(index) : name,
                fmt::format("{:.1f}", recent.frames_per_second),
                fmt::format("{:.2f}", recent.mbps),
                fmt::format("{:.0f}", recent.latency_ms),
                newest ? fmt::format("{:.0f}", milliseconds(now - newest->captured_at)) : "-",
                drops_by_cause(snapshot),
                newest ? fmt::format("{:.1f} %", 100 * hole_share(newest->frame.state)) : "-",
                millimetres(known ? known->calibration_error_mm : std::nullopt),
                millimetres(camera.disagreement_mm)};
  line.stages_ms = camera.stages_ms;
  camera.before = std::move(snapshot);
  return line;
}

std::vector<overlay::Row> OverlayReport::view_rows(Instant now, Duration elapsed) const {
  std::vector<overlay::Row> rows;
  rows.push_back({"views", fmt::format("{:.1f} per second, each rendered in {:.1f} ms",
                                       views_ / std::chrono::duration<double>(elapsed).count(),
                                       render_time_.percentile_ms(50))});
  if (const auto skew = shown_.skew(now))
    rows.push_back({"skew", fmt::format("{:.1f} ms between the cameras' pictures", milliseconds(*skew))});
  if (shares_) {
    rows.push_back(
        {"pixels", fmt::format("{:.1f} % seen, {:.1f} % remembered, {:.1f} % extended, {:.1f} % empty",
                               100 * shares_->seen, 100 * shares_->remembered, 100 * shares_->extended,
                               100 * shares_->empty)});
  }
  return rows;
}

void OverlayReport::compare_next_camera() {
  const std::size_t index = next_compared_;
  next_compared_ = (index + 1) % cameras_.size();
  const auto has_pose = [](const CameraFrame* frame) { return frame && frame->setup->has_pose; };
  std::vector<const CameraFrame*> others;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (i != index && has_pose(shown_.newest(i))) others.push_back(shown_.newest(i));
  }
  const CameraFrame* const camera = shown_.newest(index);
  cameras_[index].disagreement_mm = has_pose(camera) ? median_disagreement_mm(*camera, others) : std::nullopt;
}

}  // namespace copresence::client
