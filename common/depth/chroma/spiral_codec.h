#pragma once

// Codec spiral and its variants: depth in 13 bits. The 8 lower bits are in Y. The 5 upper bits
// select one of 32 points on an Archimedean spiral in the UV plane.
//
//   d' = round(8191 (d - near) / (far - near))                      eq. 3.8, with the whole range used
//   Y  = d' mod 256;  (U, V) = point[d' / 256]
//   r = b t, equal steps of S(t) = b/2 (t sqrt(t² + 1) + asinh t)   eq. 3.9, 3.12; a = 0, t from 5
//
// The distance between the turns, 2 pi b, equals the distance between the points. Variants:
//
//   -fold      mirrors Y where d' / 256 is odd. Y then never jumps, and a wrong upper part causes
//              only a small error.
//   -444       full-size chroma: each pixel has a point of its own.
//   -nofilter  leaves out the filter that corrects upper parts from the neighbourhood (spiral_filter.h).
//
// Error without video coding: half a step of d', plus half a unit of rounding. This holds in 4:4:4,
// and wherever the four pixels of a chroma sample share their upper bits. Elsewhere the filter
// decides.
// Parameters: near, far in the stream's unit. Source: thesis 3.3.2.

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
/// Fails (kInvalid) on impossible parameters.
Result<std::unique_ptr<PlaneDecoder>> make_spiral_decoder(SpiralVariant variant,
                                                          const DepthCodecDescription& description,
                                                          const DepthFormat& format);

}  // namespace copresence::depth
