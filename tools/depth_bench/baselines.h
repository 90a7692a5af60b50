#pragma once

// Baselines that the depth codecs are compared with. They are rvl and rvl_zstd (rvl.h), png of
// 16-bit depth, split16 and holoimage (holoimage.h). The baseline split16 codes high and low bytes
// as two 8-bit pictures in H.264.

#include <span>
#include <string>
#include <string_view>

#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/row.h"

namespace copresence::depth_bench {

std::span<const std::string_view> baseline_names();
bool is_baseline(std::string_view name);

/// Runs a baseline. The baselines split16 and holoimage run at QP 12, the others are lossless.
/// Requires is_baseline(name). Fails if the video encoder fails.
Result<Row> run_baseline(const DepthRecording& recording, const std::string& name);

}  // namespace copresence::depth_bench
