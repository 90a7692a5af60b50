#include "tools/depth_bench/tuning.h"

#include <algorithm>
#include <tuple>

#include "common/depth/depth_codec.h"
#include "tools/depth_bench/codec_run.h"

namespace copresence::depth_bench {

Result<std::vector<Row>> tune(const DepthRecording& recording, int kbps, Progress& progress) {
  std::vector<Row> rows;
  for (const std::string_view codec : depth::codec_names()) {
    const Setting setting{std::nullopt, kbps};
    progress.begin(std::string(codec) + ' ' + setting.text());
    auto row = run_codec(recording, std::string(codec), setting);
    if (!row) return fail(row.error());
    rows.push_back(std::move(*row));
  }
  std::sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) {
    const auto misses = [&](const Row& row) { return row.mbps * 1000 > 1.1 * kbps; };
    return std::tuple(misses(a), a.rmse_steps) < std::tuple(misses(b), b.rmse_steps);
  });
  return rows;
}

}  // namespace copresence::depth_bench
