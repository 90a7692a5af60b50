#pragma once

// The interface of a single depth codec, which converts depth to a picture and back. Encoder and
// Decoder (depth_codec.h) do the work that all codecs share: they fill holes, clip to the range,
// and code the validity mask. Thread: distinct objects are independent.

#include <cstdint>
#include <optional>
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

  /// Writes `out.picture` and, for a codec with a codebook, `out.table`. `out.keyframe` requests a
  /// keyframe; the codec may set it, too. Requires `depth` within the range at every pixel. Values
  /// in holes do not matter. Fails with kUnsupported if lossless coding is on but impossible.
  virtual Result<void> encode(const DepthImage& depth, const StateImage& states, PlanarDepth& out) = 0;

  /// Switches lossless coding on or off from the next frame on.
  virtual void set_lossless(bool) {}

  /// Sets the number of bits per frame at the stream's bitrate. No number means a constant QP,
  /// which is the default.
  virtual void set_bits_per_frame(std::optional<double>) {}

  /// Sets the depths that the sensor can report, ascending. It is called before the first frame.
  virtual void set_sensor_levels(std::span<const std::uint16_t>) {}
};

class PlaneDecoder {
 public:
  virtual ~PlaneDecoder() = default;

  /// Writes a depth within the range to every pixel of `out`, which has the picture's shape. Values
  /// in holes are arbitrary. Requires the described format. Fails with kCorrupt on a bad codebook
  /// change.
  virtual Result<void> decode(const PlanarDepth& in, const StateImage& states, DepthImage& out) = 0;
};

}  // namespace copresence::depth
