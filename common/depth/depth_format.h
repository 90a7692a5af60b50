#pragma once

// The shape of a stream's depth and the parameters of its codec, from the stream description. A
// description may come from an untrusted peer, so these functions check everything. Thread: pure.

#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

/// The shape and unit of a stream's depth, from the stream description.
struct DepthFormat {
  int width = 0;  ///< In pixels; even, from 2 to 4096.
  int height = 0;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  DepthNoise noise = {};

  DepthRangeUnits units() const { return to_units(range, unit); }
};

/// Fails with kInvalid for sizes outside the limits, and for a range that is empty or not finite.
/// Fails as check_noise() does, too.
Result<void> check(const DepthFormat& format);

/// Returns the codec parameter `name`. Fails with kInvalid unless the value is in [least, most].
Result<double> described(const DepthCodecDescription& description, std::string_view name, double least,
                         double most);

/// Returns near and far in the stream's unit. Fails with kInvalid unless 1 <= near < far <= 65535.
Result<DepthRangeUnits> described_range(const DepthCodecDescription& description);

}  // namespace copresence::depth
