#pragma once

// Codecs direct and triangle: U and V are two waves whose phase is the depth, and Y counts the
// periods. In 4:2:0.
//
//   Symbols: depth z, x = z - near, period P, phase u = x/P - floor(x/P).
//   Codec direct (eq. 2.7, S = 255 / number of periods):
//     U = (1 + sin 2 pi u)/2, V = (1 + cos 2 pi u)/2.
//     Y = S floor(x/P) + S/2 - (S - 2)/2 cos(pi u).
//   Codec triangle (eq. 2.8, 2.9):
//     U and V are the triangle waves Ha and Hb of period P, a quarter of a period apart.
//     Y = 255 x / (far - near).
//
// In the thesis, the last term of Y in eq. 2.7 has a plus sign, so Y jumps by almost 2 S at each
// period. This codec uses a minus sign, so Y rises only by 2 at a period, and video coding has no
// edge to blur. The thesis's K, the number of local fringes, is 0 here, which gives the smoothest
// Y.
//
// Both decoders find the phase first and then round the number of periods in Y accordingly. So Y
// may be wrong by up to half a period. The published decoding of eq. 2.9 by sections (Pece et al.
// 2011) allows only an eighth.
//
// The four pixels of a chroma sample share the phase that most of them have. Without video coding,
// the error on a surface parallel to the image is half a chroma code. This error is P/1020 for
// triangle and P/(510 pi) for direct. On other surfaces the error is up to the depth range of the
// four pixels. Parameters: near, far, period in the stream's unit. Source: thesis 2.7.2, 3.3.1;
// Zhang 2012; Pece, Kautz, Weyrich 2011.

#include <memory>
#include <optional>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

enum class Wave { kSine, kTriangle };

/// Default period in metres, the best of 0.2 to 1.6 m on a recording at 3 to 5 Mbit/s.
inline constexpr double kPeriodM = 0.6;
/// Largest number of periods in a range. With this limit, a period of `direct` takes at least four
/// codes of Y.
inline constexpr int kMostPeriods = 63;

/// Requires a period that check_period() accepts.
std::unique_ptr<PlaneEncoder> make_phase_encoder(std::string_view name, Wave wave, double period_m,
                                                 const DepthFormat& format);
/// Fails with kInvalid unless the range holds one to kMostPeriods periods.
Result<void> check_period(double period_m, const DepthFormat& format);
/// Fails with kInvalid if the parameters are impossible.
Result<std::unique_ptr<PlaneDecoder>> make_phase_decoder(Wave wave, const DepthCodecDescription& description,
                                                         const DepthFormat& format);

}  // namespace copresence::depth
