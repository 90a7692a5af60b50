#pragma once

// spiral and its variants: depth in 13 bits, the 8 lower ones in Y, the 5 upper ones as one of 32 points on
// an Archimedean spiral in the UV plane.
//
//   d' = round(8191 (d - near) / (far - near))                      eq. 3.8, with the whole range used
//   Y  = d' mod 256;  (U, V) = point[d' / 256]
//   r = b t, equal steps of S(t) = b/2 (t sqrt(t² + 1) + asinh t)   eq. 3.9 and 3.12, a = 0, from t = 5 on,
//   where the turns'
//                                                                   distance 2 pi b equals the points'
// -fold      mirrors Y where d' / 256 is odd: Y then never jumps, and a wrong upper part near a border does
// little harm -444       chroma of full size: no vote of four pixels on one point -nofilter  leaves out the
// filter that corrects upper parts which the neighbourhood contradicts
//
// Error without video coding: half a step of d', plus half a unit of rounding, in 4:4:4 and wherever the four
// pixels of a chroma sample share their upper bits. Where they do not, the filter decides (spiral_filter.h).
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
/// Fails (kInvalid) on parameters that make no sense.
Result<std::unique_ptr<PlaneDecoder>> make_spiral_decoder(SpiralVariant variant,
                                                          const DepthCodecDescription& description,
                                                          const DepthFormat& format);

}  // namespace copresence::depth
