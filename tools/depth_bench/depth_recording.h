#pragma once

// Holds a recording's depth in memory as input of all codecs. Depth outside the range is a hole.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "capture_server/temporal_filter/temporal_filter.h"
#include "common/depth/depth_format.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::depth_bench {

struct DepthRecording {
  depth::DepthFormat format;
  std::vector<std::uint16_t> levels;  ///< See SensorDescription::levels.
  std::vector<DepthImage> depth;
  std::vector<StateImage> states;
};

/// Loads the first `frames` frames, or all if `frames` is 0. Applies `temporal_filter` to them as
/// capture_server does. Fails as open_source() does, and with kEndOfStream for a recording without
/// frames.
Result<DepthRecording> load(const std::filesystem::path& recording, const DepthRange& range, int frames,
                            temporal_filter::Mode temporal_filter);

}  // namespace copresence::depth_bench
