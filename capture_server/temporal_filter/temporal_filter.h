#pragma once

// The setting of the temporal filters (depth_filter.h, color_filter.h). Thread: a plain value.

#include <cstdint>

namespace copresence::temporal_filter {

enum class Mode : std::uint8_t {
  kAuto,  ///< Filters every frame, except in lossless streams and while the camera moves.
  kOff,   ///< Filters no frame.
};

}  // namespace copresence::temporal_filter
