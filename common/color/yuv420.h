#pragma once

// Converts RGB to the YUV of a video codec, and back: full-range BT.601 (the JPEG matrix), chroma
// halved both ways.
//
// A chroma sample is the mean over 2x2 pixels; the way back gives it to all four of them. If the
// colour is constant over each 2x2 block, the round trip is exact up to rounding; greys are exact.
// Integer arithmetic gives the same result on every machine. Source: ITU-T T.871 (JFIF), section 7.
// Thread: pure; concurrent calls on distinct outputs are safe.

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::color {

/// `picture` becomes kYuv420 of the image's size. It keeps its memory if it has that shape already.
/// Requires even sizes.
void rgb_to_yuv420(const ColorImage& image, Picture& picture);

/// `image` takes the picture's size. If the colour is constant over 2x2 pixels, the error of a
/// channel after rgb_to_yuv420() and this is at most kRoundTripBound (test Yuv420.RoundTripBound).
/// Requires kYuv420.
void yuv420_to_rgb(const Picture& picture, ColorImage& image);

inline constexpr int kRoundTripBound = 2;

}  // namespace copresence::color
