#pragma once

// The validated command line of depth_bench.

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "capture_server/temporal_filter/temporal_filter.h"
#include "common/frame/depth_unit.h"
#include "common/video/video_settings.h"

namespace copresence::depth_bench {

struct Settings {
  std::filesystem::path recording;
  std::vector<std::string> codecs;
  std::vector<int> qps;
  std::vector<int> rates_kbps;
  int frames = 0;  ///< 0 means all frames.
  video::Preset preset = video::Preset::kLive;
  DepthRange range;
  temporal_filter::Mode temporal_filter = temporal_filter::Mode::kOff;
  std::optional<std::filesystem::path> json, plot;
  bool tune = false;  ///< Requires rates_kbps.
};

/// Returns the settings, or an exit code: 0 after --help and --version, 2 after an invalid command
/// line. Errors are reported on standard error.
tl::expected<Settings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::depth_bench
