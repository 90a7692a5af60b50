#pragma once

// Codecs direct and triangle: U and V are two waves whose phase is the depth, and Y counts the
// periods. 4:2:0.
//
//   x = z - near; P the period; phase u = x/P - floor(x/P)
//   direct     U = (1 + sin 2 pi u)/2, V = (1 + cos 2 pi u)/2                            eq. 2.7
//              Y = S floor(x/P) + S/2 - (S - 2)/2 cos(pi u), S = 255 / number of periods
//   triangle   U = Ha, V = Hb: triangle waves of period P, a quarter of a period apart;  eq. 2.8, 2.9
//              Y = 255 x / (far - near)
//
// The thesis's stair in Y has + cos, which jumps by almost 2 S at each period. With - cos it rises
// by 2 only, so video coding has no edge to blur. The thesis's K, the number of local fringes, is 0
// here, which gives the smoothest stair. Both decoders find the phase first and then round the
// number of periods in Y accordingly. Y may be wrong by up to half a period. Decoding eq. 2.9 by
// sections, as published (Pece et al. 2011), allows an eighth.
//
// The four pixels of a chroma sample share one phase, that of the depth of most of them. Without
// video coding the error on a surface parallel to the image is half a chroma code: P/1020
// (triangle) or P/(510 pi) (direct). On other surfaces it is up to the spread of the four pixels.
// Parameters: near, far, period in the stream's unit. Source: thesis 2.7.2, 3.3.1; Zhang 2012;
// Pece, Kautz, Weyrich 2011.

#include <memory>
#include <optional>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

enum class Wave { kSine, kTriangle };

/// Default period in metres. It has the least RMSE of 0.2 to 1.6 m on office.oni at 3 to 5 Mbit/s.
inline constexpr double kPeriodM = 0.6;
/// Most periods in a range. The stairs of `direct` are then at least four codes high.
inline constexpr int kMostPeriods = 63;

/// Requires a period that check_period() accepts.
std::unique_ptr<PlaneEncoder> make_phase_encoder(std::string_view name, Wave wave, double period_m,
                                                 const DepthFormat& format);
/// Fails (kInvalid) unless the range holds one to kMostPeriods periods.
Result<void> check_period(double period_m, const DepthFormat& format);
/// Fails (kInvalid) on impossible parameters.
Result<std::unique_ptr<PlaneDecoder>> make_phase_decoder(Wave wave, const DepthCodecDescription& description,
                                                         const DepthFormat& format);

}  // namespace copresence::depth
