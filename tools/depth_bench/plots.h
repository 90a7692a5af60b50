#pragma once

// Pictures of the bench's results, as PNG.

#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "tools/depth_bench/codec_run.h"
#include "tools/depth_bench/row.h"

namespace copresence::depth_bench {

/// Rate against RMSE and rate against the share beyond 3 sensor steps, both logarithmic, a curve per codec.
/// Each fails with kUnavailable where the file cannot be written.
Result<void> plot_curves(const std::vector<Row>& rows, const std::string& path);

/// A codec's middle frame with its name and setting.
using Shot = std::pair<std::string, Snapshot>;

/// The UV plane of every shot that has one, before video coding and after: brighter where more samples lie; after coding red the
/// farther a sample moved. Thesis figures 3.9 to 3.13. Nothing is written where no shot has chroma.
Result<void> plot_uv(const std::vector<Shot>& shots, const std::string& path);

/// Every shot's error, black for none, white for 10 sensor steps and more, blue for holes.
Result<void> plot_errors(const std::vector<Shot>& shots, DepthUnit unit, const std::string& path);

}  // namespace copresence::depth_bench
