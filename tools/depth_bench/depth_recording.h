#pragma once

// A recording's depth in memory, as every codec is given it: what lies outside the range is a hole.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/depth/depth_format.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::depth_bench {

struct DepthRecording {
  depth::DepthFormat format;
  std::vector<std::uint16_t> levels;  ///< that the sensor told, as SensorDescription::levels
  std::vector<DepthImage> depth;
  std::vector<StateImage> states;
};

/// The first `frames` frames, all of them where it is 0.
/// Fails as open_source() does, and with kEndOfStream for a recording without frames.
Result<DepthRecording> load(const std::filesystem::path& recording, const DepthRange& range, int frames);

}  // namespace copresence::depth_bench
