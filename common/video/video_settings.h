#pragma once

// Video settings that a user may choose. The preset fixes all others (docs/internals/video.md).

#include <optional>

#include "common/result.h"

namespace copresence::video {

/// Trade-off between CPU time and bits. Equal QPs give equal errors with either preset.
enum class Preset {
  kDense,  ///< Fewest bits at a speed that keeps up with one camera. For benchmarks and fast machines.
  kLive,   ///< Two thirds of kDense's time; 10 % more depth bits, 3 dB less for colour.
};

struct VideoSettings {
  Preset preset = Preset::kDense;
  /// QP of the depth pictures, 0 (lossless) to 51. A QP q at 10 bits is as coarse as q - 12 at 8
  /// bits. QPs from 1 to 7 cost more bits than lossless coding. This QP is not used if depth_kbps
  /// is set.
  int depth_qp = 12;
  /// Total rate of depth (picture, mask, codebook) in kbit/s at the nominal frame rate.
  std::optional<int> depth_kbps = std::nullopt;
  int color_kbps = 2500;
};

/// Fails with kInvalid. The message names the number and its range.
Result<void> check(const VideoSettings& settings);

inline constexpr int kMaxDepthQp = 51;
inline constexpr int kMinKbps = 50;
inline constexpr int kMaxKbps = 200'000;

}  // namespace copresence::video
