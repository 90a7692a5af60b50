#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "tools/depth_bench/baselines.h"
#include "tools/depth_bench/codec_run.h"
#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/plots.h"
#include "tools/depth_bench/row.h"
#include "tools/depth_bench/settings.h"
#include "tools/progress/progress.h"

namespace copresence::depth_bench {
namespace {

void print(tools::Progress& progress, const std::string& line) {
  progress.clear();
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::vector<Setting> settings_of(const Settings& settings) {
  std::vector<Setting> list;
  for (const int qp : settings.qps) list.push_back({qp, std::nullopt, settings.preset});
  for (const int kbps : settings.rates_kbps) list.push_back({std::nullopt, kbps, settings.preset});
  return list;
}

Result<std::vector<Row>> measure(const Settings& settings, const DepthRecording& recording,
                                 std::vector<Shot>& shots) {
  const auto list = settings_of(settings);
  int runs = 0;
  for (const std::string& codec : settings.codecs)
    runs += is_baseline(codec) ? 1 : static_cast<int>(list.size());
  tools::Progress progress(runs);
  std::vector<Row> rows;
  std::string left_out;  // Last codec that does not support this recording.
  print(progress, heading());
  for (const std::string& codec : settings.codecs) {
    if (is_baseline(codec)) {
      progress.begin(codec);
      auto row = run_baseline(recording, codec);
      if (!row) return fail(row.error());
      print(progress, line(rows.emplace_back(std::move(*row))));
      continue;
    }
    Snapshot snapshot;
    std::string shot;
    for (const Setting& setting : list) {
      const std::string title = codec + ' ' + setting.text();
      progress.begin(title);
      auto row = run_codec(recording, codec, setting, settings.plot ? &snapshot : nullptr);
      if (!row && row.error().code == ErrorCode::kUnsupported) {
        left_out = fmt::format("{}: {}", title, row.error().what);
        progress.clear();
        fmt::print(stderr, "depth_bench: {}; left out\n", left_out);
        continue;
      }
      if (!row) return fail(ErrorCode{row.error().code}, fmt::format("{}: {}", title, row.error().what));
      print(progress, line(rows.emplace_back(std::move(*row))));
      shot = title;
    }
    if (settings.plot && !shot.empty()) shots.emplace_back(shot, std::move(snapshot));
  }
  if (rows.empty()) return fail(ErrorCode::kUnsupported, left_out);
  return rows;
}

Result<std::vector<Row>> tune_all(const Settings& settings, const DepthRecording& recording) {
  tools::Progress progress(static_cast<int>(settings.rates_kbps.size() * tuning_candidates().size()));
  std::vector<Row> all;
  for (const int kbps : settings.rates_kbps) {
    const auto rows = tune(recording, kbps, settings.preset, progress);
    if (!rows) return fail(rows.error());
    print(progress, heading());
    for (const Row& row : *rows) print(progress, line(row));
    print(progress,
          fmt::format("best at {} kbit/s: --codec {} --depth-kbps {}", kbps, rows->front().codec, kbps));
    all.insert(all.end(), rows->begin(), rows->end());
  }
  return all;
}

// Inserts `ending` before the extension: NAME.png becomes NAME_uv.png.
std::string with_suffix(const std::filesystem::path& path, const char* ending) {
  return (path.parent_path() / (path.stem().string() + ending + path.extension().string())).string();
}

Result<void> run(const Settings& settings) {
  const auto recording = load(settings.recording, settings.range, settings.frames, settings.temporal_filter);
  if (!recording) return fail(recording.error());
  std::vector<Shot> shots;
  const auto rows = settings.tune ? tune_all(settings, *recording) : measure(settings, *recording, shots);
  if (!rows) return fail(rows.error());
  if (settings.json) {
    if (auto written = write_json(*rows, settings.json->string()); !written) return written;
  }
  if (settings.plot) {
    if (auto written = plot_curves(*rows, settings.plot->string()); !written) return written;
    if (auto written = plot_uv(shots, with_suffix(*settings.plot, "_uv")); !written) return written;
    if (auto written = plot_errors(shots, recording->format.unit, with_suffix(*settings.plot, "_error"));
        !written)
      return written;
  }
  return {};
}

}  // namespace
}  // namespace copresence::depth_bench

int main(int argc, char** argv) {
  const auto settings = copresence::depth_bench::read_command_line(argc, argv);
  if (!settings) return settings.error();
  if (const auto done = copresence::depth_bench::run(*settings); !done) {
    fmt::print(stderr, "depth_bench: {}\n", done.error().what);
    return 1;
  }
  return 0;
}
