#include "tools/depth_bench/tuning.h"

#include <algorithm>
#include <string>
#include <tuple>

#include "common/depth/depth_codec.h"
#include "tools/depth_bench/codec_run.h"

namespace copresence::depth_bench {

std::vector<std::string> candidates() {
  std::vector<std::string> names(depth::codec_names().begin(), depth::codec_names().end());
  for (const char* codec : {"triangle", "direct"}) {
    for (const char* period : {"0.3", "1", "1.6"}) names.push_back(std::string(codec) + ":period=" + period);
  }
  return names;
}

Result<std::vector<Row>> tune(const DepthRecording& recording, int kbps, video::Preset preset,
                              tools::Progress& progress) {
  std::vector<Row> rows;
  for (const std::string& codec : candidates()) {
    const Setting setting{std::nullopt, kbps, preset};
    progress.begin(codec + ' ' + setting.text());
    auto row = run_codec(recording, codec, setting);
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
