#include "render_client/statistics/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "render_client/stream/frame_times.h"

namespace copresence::statistics {
namespace {

using nlohmann::ordered_json;

ordered_json percentiles(const flow::LatencyHistogram& timing, std::initializer_list<int> percents) {
  ordered_json out;
  for (int percent : percents) out[fmt::format("p{}", percent)] = timing.percentile_ms(percent);
  return out;
}

constexpr auto kCounters = {&wire::FrameCounters::captured,
                            &wire::FrameCounters::encoder_busy,
                            &wire::FrameCounters::window_full,
                            &wire::FrameCounters::depth_without_color,
                            &wire::FrameCounters::color_without_depth,
                            &wire::FrameCounters::damaged,
                            &wire::FrameCounters::late,
                            &wire::FrameCounters::dark};

/// Returns whether the totals of a correct server can grow from `before` to `totals` in this time.
bool can_follow(const wire::FrameCounters& totals, const wire::FrameCounters& before, Duration elapsed) {
  // The rate is twice that of the fastest camera, because a frame has two pictures. In addition, a
  // server may hold back pictures while it is stopped.
  constexpr double kPicturesPerSecond = 2000, kHeldBack = 2000;
  const double most = kHeldBack + kPicturesPerSecond * std::chrono::duration<double>(elapsed).count();
  const bool plausible = std::all_of(kCounters.begin(), kCounters.end(), [&](const auto counter) {
    return totals.*counter >= before.*counter &&
           static_cast<double>(totals.*counter - before.*counter) <= most;
  });
  return plausible && totals.captured > before.captured;
}

double microseconds(Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

ordered_json to_json(const CameraReport& report) {
  const CameraStatistics::Snapshot& s = report.statistics;
  ordered_json camera{{"name", report.name},
                      {"left_out", report.left_out.empty() ? ordered_json() : ordered_json(report.left_out)},
                      {"connections", s.connections},
                      {"frames_captured", s.totals.captured},
                      {"frames_received", s.received},
                      {"frames_decoded", s.decoded},
                      {"frames_dropped", s.dropped},
                      {"drops", s.drops},
                      {"frames_shown", s.displayed},
                      {"frames_unshown", s.not_displayed},
                      {"times_not_believed", s.times_not_believed},
                      {"pictures",
                       {{"depth_without_color", s.totals.depth_without_color},
                        {"color_without_depth", s.totals.color_without_depth},
                        {"color_repeated", s.color_repeated},
                        {"damaged", s.totals.damaged},
                        {"late", s.totals.late},
                        {"dark", s.totals.dark}}},
                      {"times_stale", s.times_stale},
                      {"last_shown_sequence", s.last_displayed_sequence},
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

void CameraStatistics::connected() {
  std::lock_guard lock(mutex_);
  ++sums_.connections;
  last_.reset();
}

void CameraStatistics::received(const wire::FrameCounters& totals, std::size_t bytes, Instant now) {
  std::lock_guard lock(mutex_);
  if (last_ && can_follow(totals, *last_, now - last_at_)) {
    for (const auto counter : kCounters) sums_.totals.*counter += totals.*counter - (*last_).*counter;
  } else {
    sums_.totals.captured += 1;
  }
  last_ = totals;
  last_at_ = now;
  sums_.received += 1;
  if (!first_) {
    first_ = now;
  } else {
    sums_.bytes += bytes;  // The first frame is not counted, since it begins the measured interval.
  }
  newest_ = now;
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

void CameraStatistics::not_displayed() {
  std::lock_guard lock(mutex_);
  ++sums_.not_displayed;
}

void CameraStatistics::displayed(std::uint64_t sequence, std::optional<Duration> latency) {
  std::lock_guard lock(mutex_);
  ++sums_.displayed;
  sums_.last_displayed_sequence = sequence;
  if (latency) sums_.latency.add(*latency);
}

void CameraStatistics::timed(std::optional<Duration> wire, const StageDurations& durations) {
  if (wire) {
    stage(Stage::kWire, *wire);
  } else {
    std::lock_guard lock(mutex_);
    ++sums_.times_not_believed;
  }
  for (const auto& [stage_of_server, took] : {std::pair{Stage::kCapture, durations.capture},
                                              {Stage::kFill, durations.fill},
                                              {Stage::kDepthEncode, durations.depth_encode},
                                              {Stage::kVideoEncode, durations.video_encode}}) {
    if (took <= stream::kOldestBelieved) stage(stage_of_server, took);
  }
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
  const std::uint64_t missing = s.totals.captured - std::min(s.totals.captured, s.received);
  const std::uint64_t known = s.totals.encoder_busy + s.totals.window_full;
  s.drops = {{"encoder_busy", s.totals.encoder_busy},
             {"window_full", s.totals.window_full},
             {"decode_error", not_decoded_},
             {"unaccounted", missing - std::min(missing, known)}};
  s.dropped = missing + not_decoded_;
  if (first_ && *newest_ > *first_) {
    s.mbps = static_cast<double>(s.bytes) * 8e-6 / std::chrono::duration<double>(*newest_ - *first_).count();
  }
  return s;
}

CameraInterval interval(const CameraStatistics::Snapshot& before, const CameraStatistics::Snapshot& after,
                        Duration elapsed) {
  const double seconds = std::chrono::duration<double>(elapsed).count();
  CameraInterval between;
  between.frames_per_second = static_cast<double>(after.received - before.received) / seconds;
  between.mbps = static_cast<double>(after.bytes - before.bytes) * 8e-6 / seconds;
  between.latency_ms = after.latency.since(before.latency).percentile_ms(50);
  for (std::size_t i = 0; i < between.stages_ms.size(); ++i)
    between.stages_ms[i] = after.stages[i].since(before.stages[i]).percentile_ms(50);
  return between;
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

void ViewStatistics::origins(const renderer::OriginShares& shares) {
  ++views_with_origins_;
  seen_ += shares.seen;
  remembered_ += shares.remembered;
  extended_ += shares.extended;
  empty_ += shares.empty;
}

std::optional<renderer::OriginShares> ViewStatistics::mean_origins() const {
  if (views_with_origins_ == 0) return std::nullopt;
  const auto mean = [this](double sum) {
    return static_cast<float>(sum / static_cast<double>(views_with_origins_));
  };
  return renderer::OriginShares{mean(seen_), mean(remembered_), mean(extended_), mean(empty_)};
}

double ViewStatistics::fps() const {
  if (frames_ < 2) return 0;
  return static_cast<double>(frames_ - 1) / std::chrono::duration<double>(last_ - first_).count();
}

Result<void> write_statistics(const std::string& path, const std::vector<CameraReport>& cameras,
                              const ViewStatistics& view, const std::string& renderer, int width,
                              int height) {
  ordered_json root;
  root["cameras"] = ordered_json::array();
  for (const CameraReport& camera : cameras) root["cameras"].push_back(to_json(camera));
  root["view"] = {{"frames", view.frames()},
                  {"fps", view.fps()},
                  {"render_ms", percentiles(view.render_time(), {50, 95})},
                  {"skew_ms", percentiles(view.skew(), {50, 95, 99})},
                  {"renderer", renderer},
                  {"size", fmt::format("{}x{}", width, height)}};
  if (const auto shares = view.mean_origins()) {
    root["view"]["shares"] = {{"seen", shares->seen},
                              {"remembered", shares->remembered},
                              {"extended", shares->extended},
                              {"empty", shares->empty}};
  }
  if (const auto& tracker = view.head_tracker()) {
    root["view"]["head_tracker"] = {{"taken", tracker->taken},
                                    {"wrong_size", tracker->wrong_size},
                                    {"wrong_byte_order", tracker->wrong_byte_order},
                                    {"not_finite", tracker->not_finite},
                                    {"out_of_range", tracker->out_of_range}};
  }
  const auto least_sure =
      std::max_element(cameras.begin(), cameras.end(), [](const CameraReport& a, const CameraReport& b) {
        return a.statistics.clock_uncertainty < b.statistics.clock_uncertainty;
      });
  if (least_sure != cameras.end()) {
    root["clock"] = {{"offset_us", microseconds(least_sure->statistics.clock_offset)},
                     {"uncertainty_us", microseconds(least_sure->statistics.clock_uncertainty)}};
  }
  std::ofstream file(path);
  // Names and addresses may contain bytes that are not UTF-8, as JSON requires.
  file << root.dump(2, ' ', false, ordered_json::error_handler_t::replace) << '\n';
  file.flush();
  if (!file)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the statistics cannot be written there", path));
  return {};
}

}  // namespace copresence::statistics
