#pragma once

// quantized and adaptive: one 10-bit plane whose codes are the sensor's own depth levels (codebook.h).
// Without loss in video coding both are exact: every measured pixel comes back as it was.
//
// The table begins with the levels that the sensor tells (Encoder::set_sensor_levels), and learns others from measured pixels as
// they come; what a frame adds travels with it. A keyframe carries the whole table, laid out anew. Filled pixels take the nearest level and never add one. Depth with
// more than 1024 levels gets levels even in 1/z instead, from the frame on that showed it: no longer exact,
// so refused where the coding is lossless.
//
// They differ in how far levels lie apart (level_spacing.h): quantized gives every sensor step one code,
// adaptive spends all codes on the depths that the scene has, and gives none to what it has not shown yet; without loss it does as quantized. Where the scene has left them, adaptive makes a
// keyframe and lays its table out anew, at most once in two seconds.
//
// Parameters: none; the range and the unit come with the format. Source: thesis 3.3.3.2 and 3.3.3.3.

#include <memory>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

std::unique_ptr<PlaneEncoder> make_quantized_encoder(const DepthFormat& format);
std::unique_ptr<PlaneEncoder> make_adaptive_encoder(const DepthFormat& format);
/// Of both: where the codes lie is in the table.
std::unique_ptr<PlaneDecoder> make_quantized_decoder(const DepthFormat& format);

}  // namespace copresence::depth
