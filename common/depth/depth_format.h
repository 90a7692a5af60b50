#pragma once

// What a stream's description says about its depth: its shape, and the parameters of its codec. A
// description may come from an untrusted peer, so everything is checked here. Thread: pure.

#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

/// The shape of a stream's depth, as both ends know it from the stream description.
struct DepthFormat {
  int width = 0;  ///< pixels; even, 2 to 4096, as a camera's
  int height = 0;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  DepthNoise noise = {};

  DepthRangeUnits units() const { return to_units(range, unit); }
};

/// Fails (kInvalid) on sizes that no camera has, on a range that is empty or not finite, and as
/// check_noise() does.
Result<void> check(const DepthFormat& format);

/// The codec parameter `name`. Fails (kInvalid) if it is missing, not finite or outside [least,
/// most].
Result<double> described(const DepthCodecDescription& description, std::string_view name, double least,
                         double most);

/// The codec parameters near and far, in the stream's unit. Fails (kInvalid) unless 1 <= near < far
/// <= 65535.
Result<DepthRangeUnits> described_range(const DepthCodecDescription& description);

}  // namespace copresence::depth
