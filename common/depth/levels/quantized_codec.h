#pragma once

// The codecs quantized and adaptive code depth in one 10-bit plane. Its codes stand for the
// sensor's own depth levels (codebook.h). If video coding is lossless, every measured pixel is
// decoded exactly.
//
// The codebook begins with the levels that the sensor advertises (Encoder::set_sensor_levels) and
// learns others from measured pixels. A frame carries the levels that it adds. A keyframe carries
// the whole codebook with new spacing. Filled pixels take the nearest level and never add a level.
// If more than 1024 levels appear, the codebook gets levels even in 1/z instead. Coding is then no
// longer exact, so lossless coding is refused.
//
// The codecs differ in the spacing of the levels. The codec quantized gives every disparity step
// one code. The codec adaptive gives no code to levels that have not appeared yet. At a constant
// QP, it spends all codes on the depths in the scene. At a bitrate, it spaces all levels evenly in
// 1/z (Encoder::set_bitrate). If another spacing would be much finer for the scene, adaptive makes
// a keyframe with that spacing, at most every 30 frames. In lossless coding, adaptive works like
// quantized.
//
// The codecs have no parameters; the format has range and unit. Source: thesis 3.3.3.2, 3.3.3.3.

#include <memory>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

std::unique_ptr<PlaneEncoder> make_quantized_encoder(const DepthFormat& format);
std::unique_ptr<PlaneEncoder> make_adaptive_encoder(const DepthFormat& format);
/// Decodes both codecs, since the codebook holds the spacing.
std::unique_ptr<PlaneDecoder> make_quantized_decoder(const DepthFormat& format);

}  // namespace copresence::depth
