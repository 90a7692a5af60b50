#pragma once

// Codings that the project's codecs are compared with: rvl and rvl_zstd (rvl.h), png of the 16-bit depth, split16
// (high and low bytes as two 8-bit pictures through H.264), and holoimage (holoimage.h).

#include <span>
#include <string>
#include <string_view>

#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/row.h"

namespace copresence::depth_bench {

std::span<const std::string_view> baseline_names();
bool is_baseline(std::string_view name);

/// Runs a baseline: `split16` and `holoimage` at QP 12, the others lossless. Requires a baseline's name.
/// Fails as the video encoder does.
Result<Row> run_baseline(const DepthRecording& recording, const std::string& name);

}  // namespace copresence::depth_bench
