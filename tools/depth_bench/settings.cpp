#include "tools/depth_bench/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/command_line/mistakes.h"
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

// Known before a long run rather than after it.
std::string can_be_written(const std::string& path) {
  if (path.empty()) return "\"\" is not a file's name";
  const auto folder = std::filesystem::path(path).parent_path();
  if (folder.empty() || std::filesystem::is_directory(folder)) return {};
  return fmt::format("there is no folder {} for {}", folder.string(), path);
}

}  // namespace

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  Settings settings;
  const auto known = all_codecs();
  CLI::App app{
      "Codes the depth of a recording with the codecs and settings asked for, decodes it again and reports "
      "rate, "
      "error and time of each: a table on standard output, --json and --plot for more.",
      "depth_bench"};
  app.set_version_flag("--version", std::string("depth_bench ") + COPRESENCE_VERSION);
  app.add_option("RECORDING", settings.recording, "an .oni recording")->required()->check(existing_file());
  app.add_option(
         "--codec", settings.codecs,
         fmt::format("codecs, or all (default quantized); triangle and direct also as NAME:period=METRES: {}",
                     fmt::join(known, ", ")))
      ->delimiter(',')
      ->check([&](const std::string& name) {
        const bool is_known = name == "all" || std::find(known.begin(), known.end(),
                                                         name.substr(0, name.find(':'))) != known.end();
        return is_known ? std::string()
                        : fmt::format("there is no codec \"{}\"; choose from all, {}", name,
                                      fmt::join(known, ", "));
      });
  app.add_option("--qp", settings.qps,
                 "constant quantisers, 0 (lossless) to 51 (default 0,12 without --kbps)")
      ->delimiter(',')
      ->check(whole_number(0, video::kMaxDepthQp));
  app.add_option("--kbps", settings.rates_kbps,
                 "rates of everything that depth costs, kbit/s at 30 frames a second")
      ->delimiter(',')
      ->check(whole_number(video::kMinKbps, video::kMaxKbps));
  app.add_option("--frames", settings.frames, "how many of the recording's frames (default all)")
      ->check(whole_number(1, 1'000'000));
  std::string effort = "live";
  app.add_option("--effort", effort,
                 "live (default): H.264 as capture_server codes it; dense: about a sixth fewer bits for half "
                 "more time")
      ->check(one_of({"live", "dense"}));
  add_depth_range(app, "--range", settings.range,
                  "depth in metres that counts, NEAR:FAR; the rest are holes");
  app.add_option("--json", settings.json, "file for the rows as JSON")->check(can_be_written);
  app.add_option("--plot", settings.plot,
                 "PNG of rate against RMSE and against the share beyond 3 sensor steps; beside it, with _uv "
                 "and _error in "
                 "the name, the UV plane before and after coding and a frame's error")
      ->check(can_be_written);
  app.add_flag("--tune", settings.tune,
               "searches codec and parameters for the best RMSE in sensor steps at each --kbps and prints "
               "the setting");
  try {
    app.parse(argc, argv);
    if (settings.tune && settings.rates_kbps.empty()) {
      throw CLI::ValidationError("--tune", "needs a rate to tune for: give --kbps N");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(explain(app, error));
  }
  if (effort == "dense") settings.preset = video::Preset::kDense;
  if (settings.codecs.empty()) settings.codecs = {"quantized"};
  if (std::find(settings.codecs.begin(), settings.codecs.end(), "all") != settings.codecs.end())
    settings.codecs = known;
  if (settings.qps.empty() && settings.rates_kbps.empty()) settings.qps = {0, 12};
  return settings;
}

}  // namespace copresence::depth_bench
