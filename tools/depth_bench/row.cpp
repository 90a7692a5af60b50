#include "tools/depth_bench/row.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace copresence::depth_bench {
namespace {

constexpr double kFramesPerSecond = 30;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void conclude(const Tally& tally, const DepthError& error, Row& row) {
  const auto frames = static_cast<double>(tally.encode_ms.size());
  row.frames = static_cast<int>(tally.encode_ms.size());
  row.mbps = static_cast<double>(tally.bytes) * 8 * kFramesPerSecond / frames / 1e6;
  row.mask_mbps = static_cast<double>(tally.mask_bytes) * 8 * kFramesPerSecond / frames / 1e6;
  row.max_frame_kb = static_cast<double>(tally.largest) / 1000;
  row.encode_ms = median(tally.encode_ms);
  row.decode_ms = median(tally.decode_ms);
  row.rmse_mm = error.rmse_mm();
  row.rmse_steps = error.rmse_steps();
  row.mae_mm = error.mae_mm();
  row.p50_mm = error.percentile_mm(0.5);
  row.p99_mm = error.percentile_mm(0.99);
  row.max_mm = error.max_mm();
  row.p99_steps = error.percentile_steps(0.99);
  row.percent_beyond_3_steps = error.percent_beyond_3_steps();
  row.percent_beyond_100mm = error.percent_beyond_100mm();
  row.percent_flying = error.percent_flying();
  row.hole_flips = error.hole_flips();
}

Result<void> write_json(const std::vector<Row>& rows, const std::string& path) {
  auto list = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    list.push_back({{"codec", row.codec},
                    {"pixel_format", row.pixel_format},
                    {"setting", row.setting},
                    {"mbps", row.mbps},
                    {"mask_mbps", row.mask_mbps},
                    {"rmse_mm", row.rmse_mm},
                    {"rmse_steps", row.rmse_steps},
                    {"mae_mm", row.mae_mm},
                    {"p50_mm", row.p50_mm},
                    {"p99_mm", row.p99_mm},
                    {"max_mm", row.max_mm},
                    {"p99_steps", row.p99_steps},
                    {"percent_beyond_3_steps", row.percent_beyond_3_steps},
                    {"percent_beyond_100mm", row.percent_beyond_100mm},
                    {"percent_flying", row.percent_flying},
                    {"hole_flips", row.hole_flips},
                    {"encode_ms", row.encode_ms},
                    {"decode_ms", row.decode_ms},
                    {"max_frame_kb", row.max_frame_kb},
                    {"frames", row.frames}});
  }
  std::ofstream file(path);
  file << list.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  file.close();
  if (!file) return fail(ErrorCode::kUnavailable, fmt::format("{}: the results cannot be written", path));
  return {};
}

std::string heading() {
  return fmt::format("{:<26}{:<8}{:>10}{:>8}{:>7}{:>9}{:>7}{:>8}{:>9}{:>9}{:>8}{:>8}{:>7}{:>8}", "codec",
                     "format", "setting", "Mbit/s", "mask", "RMSE mm", "steps", "p99 mm", ">3st %",
                     ">100mm %", "flying %", "enc ms", "dec ms", "max kB");
}

std::string line(const Row& row) {
  return fmt::format(
      "{:<26}{:<8}{:>10}{:>8.3f}{:>7.3f}{:>9.2f}{:>7.2f}{:>8.1f}{:>9.3f}{:>9.3f}{:>8.2f}{:>8.2f}{:>7.2f}{:>8."
      "1f}",
      row.codec, row.pixel_format, row.setting, row.mbps, row.mask_mbps, row.rmse_mm, row.rmse_steps,
      row.p99_mm, row.percent_beyond_3_steps, row.percent_beyond_100mm, row.percent_flying, row.encode_ms,
      row.decode_ms, row.max_frame_kb);
}

double thread_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

}  // namespace copresence::depth_bench
