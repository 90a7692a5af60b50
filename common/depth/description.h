#pragma once

// Reading a codec's numbers out of a stream description, which comes from the other side and may say
// anything.

#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

/// The parameter `name`. Fails (kInvalid) where it is missing, not finite or outside [least, most].
Result<double> described(const DepthCodecDescription& description, std::string_view name, double least,
                         double most);

/// The parameters near and far, in the stream's unit. Fails (kInvalid) unless 1 <= near < far <= 65535.
Result<DepthRangeUnits> described_range(const DepthCodecDescription& description);

}  // namespace copresence::depth
