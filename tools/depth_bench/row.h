#pragma once

// One result: a codec with a setting, its bitrate, error and time. docs/internals/compression.md
// describes the keys of the JSON.

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/depth_bench/depth_error.h"

namespace copresence::depth_bench {

struct Row {
  std::string codec;
  /// One of gray8, gray10, yuv420 and yuv444, or "none" without a video codec.
  std::string pixel_format;
  std::string setting;   ///< Such as qp=12, kbps=1000, or lossless.
  double mbps = 0;       ///< Total bitrate at 30 frames per second.
  double mask_mbps = 0;  ///< Bitrate of the validity mask, part of mbps.
  double rmse_mm = 0, rmse_steps = 0, mae_mm = 0, p50_mm = 0, p99_mm = 0, max_mm = 0, p99_steps = 0;
  double percent_beyond_3_steps = 0, percent_beyond_100mm = 0, percent_flying = 0;
  std::uint64_t hole_flips = 0;
  /// Median CPU time per frame on one thread, including the mask.
  double encode_ms = 0, decode_ms = 0;
  double max_frame_kb = 0;
  int frames = 0;
};

/// Sizes and times of all frames of a run.
struct Tally {
  std::uint64_t bytes = 0, mask_bytes = 0, largest = 0;
  std::vector<double> encode_ms, decode_ms;
};

/// Sets all members of a row except codec, pixel_format and setting. Requires at least one frame.
void conclude(const Tally& tally, const DepthError& error, Row& row);

/// Writes rows as a JSON list. Fails with kUnavailable if the file cannot be written.
Result<void> write_json(const std::vector<Row>& rows, const std::string& path);

/// The heading and one line of the table on standard output.
std::string heading();
std::string line(const Row& row);

/// CPU time of this thread in milliseconds.
double thread_ms();

}  // namespace copresence::depth_bench
