#pragma once

// direct and triangle: depth as the phase of two waves in U and V, with Y to count the periods. 4:2:0.
//
//   x = z - near; P the period; phase u = x/P - floor(x/P)
//   direct     U = (1 + sin 2 pi u)/2, V = (1 + cos 2 pi u)/2                                          eq. 2.7
//              Y = S floor(x/P) + S/2 - (S - 2)/2 cos(pi u), S = 255 / number of periods
//   triangle   U = Ha, V = Hb: triangle waves of period P, a quarter of a period apart; Y = 255 x / (far - near)   eq. 2.8, 2.9
//
// The thesis's stair has + cos, which jumps by almost 2 S at each period; with - cos it goes on by 2 and leaves video coding
// nothing to blur. Its K, the number of local fringes, is 0 here: half a cosine, the smoothest stair.
// Both decode the phase first and then round the number of periods that Y tells to it: this bears an error of Y of half a
// period, where decoding eq. 2.9 by sections, as published (Pece et al. 2011), bears an eighth.
//
// The four pixels of a chroma sample share one phase, of the depth that most of them agree on. Error without video coding: half
// a chroma code, P/1020 (triangle) or P/(510 pi) (direct), on a surface parallel to the image; on others up to the
// spread of the four pixels.
// Parameters: near, far, period in the stream's unit. Source: thesis 2.7.2, 3.3.1; Zhang 2012; Pece, Kautz, Weyrich 2011.

#include <memory>
#include <optional>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

enum class Wave { kSine, kTriangle };

inline constexpr double kPeriodM =
    0.6;  ///< metres; the least RMSE of 0.2 to 1.6 on office.oni at 3 to 5 Mbit/s
inline constexpr int kMostPeriods = 63;  ///< of a range, so that direct's stairs are four codes high or more

/// Requires a period that check_period() accepts.
std::unique_ptr<PlaneEncoder> make_phase_encoder(std::string_view name, Wave wave, double period_m,
                                                 const DepthFormat& format);
/// Fails (kInvalid) unless the range holds one to kMostPeriods periods.
Result<void> check_period(double period_m, const DepthFormat& format);
/// Fails (kInvalid) on parameters that make no sense.
Result<std::unique_ptr<PlaneDecoder>> make_phase_decoder(Wave wave, const DepthCodecDescription& description,
                                                         const DepthFormat& format);

}  // namespace copresence::depth
