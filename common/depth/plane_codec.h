#pragma once

// What every depth codec is inside: depth to a picture and back, holes already filled for coding, states out
// of the way. depth_codec.h wraps range, mask, filling and seal around one of these.
//
// Thread: distinct objects are independent.

#include <cstdint>
#include <span>

#include "common/depth/depth_format.h"
#include "common/frame/coded_frame.h"
#include "common/frame/image.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

class PlaneEncoder {
 public:
  virtual ~PlaneEncoder() = default;

  virtual DepthCodecDescription description() const = 0;

  /// Writes `out.picture` and, where there is one, `out.table`; `out.keyframe` is set, and may be raised.
  /// Requires `depth` within the range at every pixel, the values that matter where `states` is not kHole.
  /// Fails (kUnsupported) where it must be exact and cannot.
  virtual Result<void> encode(const DepthImage& depth, const StateImage& states, PlanarDepth& out) = 0;

  /// From the next frame on the pictures are coded without loss, or no longer.
  virtual void set_lossless(bool) {}

  /// The depths that the sensor can report, ascending; before the first frame.
  virtual void set_sensor_levels(std::span<const std::uint16_t>) {}
};

class PlaneDecoder {
 public:
  virtual ~PlaneDecoder() = default;

  /// Writes a depth within the range to every pixel of `out`, which has the picture's shape; those of holes
  /// mean nothing. Requires a picture of the described format. Fails (kCorrupt) on tables that make no sense.
  virtual Result<void> decode(const PlanarDepth& in, const StateImage& states, DepthImage& out) = 0;
};

}  // namespace copresence::depth
