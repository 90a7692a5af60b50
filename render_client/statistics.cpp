#include "render_client/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace copresence::client {
namespace {

using nlohmann::ordered_json;

ordered_json percentiles(const flow::StageTiming& timing, std::initializer_list<int> percents) {
  ordered_json out;
  for (int percent : percents) out[fmt::format("p{}", percent)] = timing.percentile_ms(percent);
  return out;
}

double microseconds(Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

ordered_json to_json(const std::string& name, const CameraStatistics::Snapshot& s) {
  ordered_json camera{{"name", name},
                      {"frames_captured", s.captured},
                      {"frames_received", s.received},
                      {"frames_decoded", s.decoded},
                      {"frames_dropped", s.dropped},
                      {"drops", s.drops},
                      {"frames_shown", s.latency.count()},
                      {"frames_unshown", s.unshown},
                      {"pictures",
                       {{"depth_without_color", s.pictures.depth_without_color},
                        {"color_without_depth", s.pictures.color_without_depth},
                        {"color_repeated", s.color_repeated},
                        {"damaged", s.pictures.damaged},
                        {"dark", s.pictures.dark}}},
                      {"times_stale", s.times_stale},
                      {"last_shown_sequence", s.last_shown_sequence},
                      {"mbps", s.mbps},
                      {"latency_ms", percentiles(s.latency, {50, 95, 99})}};
  ordered_json stages;
  for (std::size_t i = 0; i < kStageNames.size(); ++i) {
    stages[kStageNames[i]] = percentiles(s.stages[i], {50, 95});
  }
  camera["stages_ms"] = std::move(stages);
  camera["clock"] = {{"offset_us", microseconds(s.clock_offset)},
                     {"uncertainty_us", microseconds(s.clock_uncertainty)}};
  return camera;
}

}  // namespace

void CameraStatistics::received(std::uint64_t captured, std::uint64_t encoder_busy, std::uint64_t window_full,
                                std::size_t bytes, Instant now) {
  std::lock_guard lock(mutex_);
  if (!last_ || captured <= last_->captured || encoder_busy < last_->encoder_busy ||
      window_full < last_->window_full) {
    sums_.captured += 1;  // joined a stream: what it captured before is not ours to count
  } else {
    sums_.captured += captured - last_->captured;
    encoder_busy_ += encoder_busy - last_->encoder_busy;
    window_full_ += window_full - last_->window_full;
  }
  last_ = Totals{captured, encoder_busy, window_full};
  sums_.received += 1;
  if (!first_) {
    first_ = now;
  } else {
    bytes_ += bytes;  // the first frame opens the interval that the rate is measured over
  }
  newest_ = now;
}

void CameraStatistics::sensor(const Pictures& totals) {
  std::lock_guard lock(mutex_);
  // A total that falls is a server's that started anew.
  const auto growth = [&](std::uint64_t Pictures::*total) {
    return last_pictures_ && totals.*total >= (*last_pictures_).*total
               ? totals.*total - (*last_pictures_).*total
               : std::uint64_t{0};
  };
  for (auto total : {&Pictures::depth_without_color, &Pictures::color_without_depth, &Pictures::damaged,
                     &Pictures::dark}) {
    sums_.pictures.*total += growth(total);
  }
  last_pictures_ = totals;
}

void CameraStatistics::decoded() {
  std::lock_guard lock(mutex_);
  ++sums_.decoded;
}

void CameraStatistics::stale() {
  std::lock_guard lock(mutex_);
  ++sums_.times_stale;
}

void CameraStatistics::color_repeated() {
  std::lock_guard lock(mutex_);
  ++sums_.color_repeated;
}

void CameraStatistics::not_decoded() {
  std::lock_guard lock(mutex_);
  ++not_decoded_;
}

void CameraStatistics::unshown() {
  std::lock_guard lock(mutex_);
  ++sums_.unshown;
}

void CameraStatistics::shown(std::uint64_t sequence, Duration latency) {
  std::lock_guard lock(mutex_);
  sums_.last_shown_sequence = sequence;
  sums_.latency.add(latency);
}

void CameraStatistics::stage(Stage stage, Duration duration) {
  std::lock_guard lock(mutex_);
  sums_.stages[static_cast<std::size_t>(stage)].add(duration);
}

void CameraStatistics::clock(Duration offset, Duration uncertainty) {
  std::lock_guard lock(mutex_);
  sums_.clock_offset = offset;
  sums_.clock_uncertainty = uncertainty;
}

CameraStatistics::Snapshot CameraStatistics::snapshot() const {
  std::lock_guard lock(mutex_);
  Snapshot s = sums_;
  const std::uint64_t missing = s.captured - std::min(s.captured, s.received);
  const std::uint64_t known = encoder_busy_ + window_full_;
  s.drops = {{"encoder_busy", encoder_busy_},
             {"window_full", window_full_},
             {"decode_error", not_decoded_},
             {"unaccounted", missing - std::min(missing, known)}};
  s.dropped = missing + not_decoded_;
  if (first_ && *newest_ > *first_) {
    s.mbps = static_cast<double>(bytes_) * 8e-6 / std::chrono::duration<double>(*newest_ - *first_).count();
  }
  return s;
}

void ViewStatistics::rendered(Instant begin, Instant end, bool complete) {
  if (frames_ == 0) {
    if (!complete) return;
    first_ = end;
  }
  ++frames_;
  last_ = end;
  render_time_.add(end - begin);
}

double ViewStatistics::fps() const {
  if (frames_ < 2) return 0;
  return static_cast<double>(frames_ - 1) / std::chrono::duration<double>(last_ - first_).count();
}

Result<void> write_statistics(const std::string& path, const std::vector<std::string>& cameras,
                              const std::vector<CameraStatistics::Snapshot>& snapshots,
                              const ViewStatistics& view, const std::string& renderer, int width,
                              int height) {
  ordered_json root;
  root["cameras"] = ordered_json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i)
    root["cameras"].push_back(to_json(cameras[i], snapshots[i]));
  root["view"] = {{"frames", view.frames()},
                  {"fps", view.fps()},
                  {"render_ms", percentiles(view.render_time(), {50, 95})},
                  {"skew_ms", percentiles(view.skew(), {50, 95, 99})},
                  {"renderer", renderer},
                  {"size", fmt::format("{}x{}", width, height)}};
  if (const auto& tracker = view.head_tracker()) {
    root["view"]["head_tracker"] = {{"taken", tracker->taken},
                                    {"wrong_size", tracker->wrong_size},
                                    {"wrong_byte_order", tracker->wrong_byte_order},
                                    {"not_finite", tracker->not_finite},
                                    {"out_of_range", tracker->out_of_range}};
  }
  const auto least_sure = std::max_element(
      snapshots.begin(), snapshots.end(),
      [](const auto& a, const auto& b) { return a.clock_uncertainty < b.clock_uncertainty; });
  if (least_sure != snapshots.end()) {
    root["clock"] = {{"offset_us", microseconds(least_sure->clock_offset)},
                     {"uncertainty_us", microseconds(least_sure->clock_uncertainty)}};
  }
  std::ofstream file(path);
  file << root.dump(2) << '\n';
  file.flush();
  if (!file)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the statistics cannot be written there", path));
  return {};
}

}  // namespace copresence::client
