#include "tools/depth_bench/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"
#include "common/depth/depth_codec.h"
#include "common/video/video_settings.h"
#include "tools/depth_bench/baselines.h"

namespace copresence::depth_bench {
namespace {

std::vector<std::string> all_codecs() {
  std::vector<std::string> names;
  for (const std::string_view name : depth::codec_names()) names.emplace_back(name);
  for (const std::string_view name : baseline_names()) names.emplace_back(name);
  return names;
}

}  // namespace

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  Settings settings;
  const auto known = all_codecs();
  CLI::App app{
      "Measures depth codecs on a recording: codes and decodes all frames with each codec and setting, and "
      "prints a "
      "table of bitrates, errors and times. --json and --plot write more.",
      "depth_bench"};
  app.set_version_flag("--version", std::string("depth_bench ") + COPRESENCE_VERSION);
  app.add_option("RECORDING", settings.recording, "an .oni recording")->required()->check(existing_file());
  app.add_option(
         "--codec", settings.codecs,
         fmt::format("codecs, separated by commas, or all (default quantized); triangle and direct also as "
                     "NAME:period=METRES: {}",
                     fmt::join(known, ", ")))
      ->delimiter(',')
      ->check([&](const std::string& name) {
        const bool is_known = name == "all" || std::find(known.begin(), known.end(),
                                                         name.substr(0, name.find(':'))) != known.end();
        return is_known ? std::string()
                        : fmt::format("there is no codec \"{}\"; choose from all, {}", name,
                                      fmt::join(known, ", "));
      });
  app.add_option("--qp", settings.qps, "constant QPs, 0 (lossless) to 51 (default 0,12 without --kbps)")
      ->delimiter(',')
      ->check(whole_number(0, video::kMaxDepthQp));
  app.add_option("--kbps", settings.rates_kbps,
                 "bitrates of depth including its mask, kbit/s at 30 frames per second")
      ->delimiter(',')
      ->check(whole_number(video::kMinKbps, video::kMaxKbps));
  app.add_option("--frames", settings.frames, "number of frames to use (default all)")
      ->check(whole_number(1, 1'000'000));
  std::string effort = "live";
  app.add_option("--effort", effort,
                 "live (default): the H.264 preset of capture_server; dense: a sixth fewer bits in one and a "
                 "half times the time")
      ->check(one_of({"live", "dense"}));
  add_depth_range(app, "--range", settings.range,
                  "depth range in metres, NEAR:FAR; other depth becomes holes");
  app.add_option("--temporal-filter", settings.temporal_filter,
                 "auto: filter the depth as capture_server does before coding; off (default): as recorded")
      ->transform(one_of<temporal_filter::Mode>(
          {{"auto", temporal_filter::Mode::kAuto}, {"off", temporal_filter::Mode::kOff}}));
  app.add_option("--json", settings.json, "file for the results as JSON")->check(writable_file());
  app.add_option(
         "--plot", settings.plot,
         "PNG with RMSE and the share of errors above 3 disparity steps against the bitrate; two more "
         "files with _uv and _error in the name show the UV plane before and after coding and the error "
         "of a frame")
      ->check(writable_file());
  app.add_flag("--tune", settings.tune,
               "find the codec and parameters with the lowest RMSE in disparity steps at each --kbps");
  try {
    app.parse(argc, argv);
    if (settings.tune && settings.rates_kbps.empty()) {
      throw CLI::ValidationError("--tune", "needs a bitrate: give --kbps N");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(report_parse_error(app, error));
  }
  if (effort == "dense") settings.preset = video::Preset::kDense;
  if (settings.codecs.empty()) settings.codecs = {"quantized"};
  if (std::find(settings.codecs.begin(), settings.codecs.end(), "all") != settings.codecs.end())
    settings.codecs = known;
  if (settings.qps.empty() && settings.rates_kbps.empty()) settings.qps = {0, 12};
  return settings;
}

}  // namespace copresence::depth_bench
