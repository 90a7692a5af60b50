#pragma once

// The video settings that a user may choose. All other settings are fixed by the preset
// (docs/internals/video.md).

#include <optional>

#include "common/result.h"

namespace copresence::video {

/// Trade-off between processor time and bits, for both pictures. Equal QPs give equal errors with
/// either preset.
enum class Preset {
  kDense,  ///< fewest bits at a speed that still keeps up with one camera; for benchmarks and fast machines
  kLive,   ///< two thirds of the time at both ends; a tenth more bits for depth, 3 dB less for colour
};

struct VideoSettings {
  Preset preset = Preset::kDense;
  /// QP of the depth pictures, 0 (lossless) to 51. At 10 bits a QP is as coarse as one that is
  /// lower by 12 at 8 bits. QPs from 1 to 7 cost more bits than lossless coding. Not used if
  /// depth_kbps is set.
  int depth_qp = 12;
  /// Bit rate of all of depth (picture, mask and codebook) at the stream's nominal frame rate,
  /// kbit/s.
  std::optional<int> depth_kbps = std::nullopt;
  int color_kbps = 2500;
};

/// Fails with kInvalid; the message names the number and its range.
Result<void> check(const VideoSettings& settings);

inline constexpr int kMaxDepthQp = 51;
inline constexpr int kMinKbps = 50;
inline constexpr int kMaxKbps = 200'000;

}  // namespace copresence::video
