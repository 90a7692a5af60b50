#pragma once

// What a person may choose about video. Everything else is a preset, measured once (docs/internals/video.md).

#include <optional>

#include "common/result.h"

namespace copresence::video {

/// What encoding may cost in processor time, both pictures. The same quantiser means the same error with either.
enum class Preset {
  kDense,  ///< fewest bits that still keep up with one camera: benches, recordings, fast machines
  kLive,  ///< two thirds of the time to encode and to decode for a tenth more bits of depth and 3 dB of colour
};

struct VideoSettings {
  Preset preset = Preset::kDense;
  /// Quantiser of the depth pictures, 0 (lossless) to 51 for 8 bit and 63 for 10 bit; 12 more there are as
  /// coarse as at 8 bit. From 1 to 7 costs more than lossless. Not used when depth_kbps is set.
  int depth_qp = 12;
  /// Everything that depth costs: picture, mask and table, kbit/s at the stream's nominal rate.
  std::optional<int> depth_kbps = std::nullopt;
  int color_kbps = 2500;
};

/// Fails with kInvalid and a sentence that names the number and its range.
Result<void> check(const VideoSettings& settings);

inline constexpr int kMaxDepthQp = 51;
inline constexpr int kMinKbps = 50;
inline constexpr int kMaxKbps = 200'000;

}  // namespace copresence::video
