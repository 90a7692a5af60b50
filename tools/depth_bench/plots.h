#pragma once

// Plots of the results as PNG. All functions fail with kUnavailable if the file cannot be written.

#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "tools/depth_bench/codec_run.h"
#include "tools/depth_bench/row.h"

namespace copresence::depth_bench {

/// Plots RMSE and the share of errors above 3 disparity steps against the bitrate, with one curve
/// per codec and logarithmic axes.
Result<void> plot_curves(const std::vector<Row>& rows, const std::string& path);

/// Codec and setting, and a snapshot of a coded frame.
using Shot = std::pair<std::string, Snapshot>;

/// Plots the distribution of chroma samples in the UV plane before and after video coding, as in
/// thesis figures 3.9 to 3.13. Darker means more samples; after coding, red means that samples
/// moved far. Writes no file if no snapshot has chroma.
Result<void> plot_uv(const std::vector<Shot>& shots, const std::string& path);

/// Plots the error of every snapshot: black for no error, white for 10 disparity steps or more,
/// blue for a hole.
Result<void> plot_errors(const std::vector<Shot>& shots, DepthUnit unit, const std::string& path);

}  // namespace copresence::depth_bench
