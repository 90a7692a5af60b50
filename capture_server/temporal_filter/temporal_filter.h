#pragma once

// Setting of the temporal filter (depth_filter.h, color_filter.h). Thread: a value.

#include <cstdint>

namespace copresence::temporal_filter {

enum class Mode : std::uint8_t {
  kAuto,  ///< filters, except lossless streams and while the camera moves
  kOff,
};

}  // namespace copresence::temporal_filter
