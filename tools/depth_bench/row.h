#pragma once

// One line of the bench: a codec at a setting, what it costs and what it loses. Keys of the JSON are in docs/internals/compression.md.

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/depth_bench/depth_error.h"

namespace copresence::depth_bench {

struct Row {
  std::string codec;
  std::string pixel_format;  ///< gray8, gray10, yuv420, yuv444; "none" where no video codec is involved
  std::string setting;       ///< qp=12, kbps=1000, or lossless
  double mbps = 0;           ///< at 30 frames a second, everything included
  double mask_mbps = 0;      ///< of that, the state mask
  double rmse_mm = 0, rmse_steps = 0, mae_mm = 0, p50_mm = 0, p99_mm = 0, max_mm = 0, p99_steps = 0;
  double percent_beyond_3_steps = 0, percent_beyond_100mm = 0, percent_flying = 0;
  std::uint64_t hole_flips = 0;
  double encode_ms = 0, decode_ms = 0;  ///< median processor time of a frame, on one thread, mask included
  double max_frame_kb = 0;
  int frames = 0;
};

/// What a run gathers frame by frame.
struct Tally {
  std::uint64_t bytes = 0, mask_bytes = 0, largest = 0;
  std::vector<double> encode_ms, decode_ms;
};

/// Fills everything of a row but its name, format and setting. Requires at least one frame.
void conclude(const Tally& tally, const DepthError& error, Row& row);

/// Writes rows as the design's JSON list. Fails with kUnavailable where the file cannot be written.
Result<void> write_json(const std::vector<Row>& rows, const std::string& path);

/// A line of the table on standard output, and its heading.
std::string heading();
std::string line(const Row& row);

/// Processor time of this thread, milliseconds.
double thread_ms();

}  // namespace copresence::depth_bench
