#pragma once

// Codec spiral and its variants: depth in 13 bits. The 8 lower bits are in Y. The 5 upper bits
// select one of 32 points on an Archimedean spiral in the UV plane.
//
//   Code of depth d (eq. 3.8, with the whole range used): d' = round(8191 (d - near) / (far - near)).
//   Samples: Y = d' mod 256, (U, V) = point[d' / 256].
//   Spiral (eq. 3.9 with a = 0): radius r = b t, where the angle t starts at 5.
//   Points (eq. 3.12): placed at equal steps of the arc length b/2 (t sqrt(t² + 1) + asinh t).
//
// The distance between the turns, 2 pi b, equals the distance between the points. Variants:
//
//   `-fold` mirrors Y where d' / 256 is odd. Y then never jumps, and wrong upper bits cause only a
//   small error.
//   `-444` uses full-size chroma, so each pixel has its own point.
//   `-nofilter` omits the filter that corrects upper bits (spiral_filter.h).
//
// Without video coding, the error is half a step of d' plus half a unit of rounding. This error
// holds in 4:4:4, and wherever the four pixels of a chroma sample share their upper bits. Elsewhere
// the error depends on the filter. Parameters: near, far in the stream's unit. Source: thesis
// 3.3.2.

#include <memory>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

struct SpiralVariant {
  bool fold = false, full_chroma = false, filter = true;
};

std::unique_ptr<PlaneEncoder> make_spiral_encoder(std::string_view name, SpiralVariant variant,
                                                  const DepthFormat& format);
/// Fails with kInvalid if the parameters are impossible.
Result<std::unique_ptr<PlaneDecoder>> make_spiral_decoder(SpiralVariant variant,
                                                          const DepthCodecDescription& description,
                                                          const DepthFormat& format);

}  // namespace copresence::depth
