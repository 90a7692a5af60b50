#pragma once

// The best codec for a recording at a rate (thesis 5.1.2).

#include <string>
#include <vector>

#include "common/video/video_settings.h"
#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/row.h"
#include "tools/progress/progress.h"

namespace copresence::depth_bench {

/// What tune() tries: every codec, and some with other parameters.
std::vector<std::string> candidates();

/// Rows of all candidates at the rate, the least RMSE in sensor steps first. Codecs that cannot hold the rate within a tenth come last.
/// Fails as run_codec() does.
Result<std::vector<Row>> tune(const DepthRecording& recording, int kbps, video::Preset preset,
                              tools::Progress& progress);

}  // namespace copresence::depth_bench
