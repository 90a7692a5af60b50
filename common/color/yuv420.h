#pragma once

// Converts RGB to the YUV of a video codec, and back. The format is full-range BT.601 (the JPEG
// matrix) with chroma of half the width and height.
//
// A chroma sample is the mean of 2x2 pixels. Converting back gives all four pixels this value. The
// round trip is exact for greys, and exact up to rounding if each 2x2 block has one colour. Integer
// arithmetic gives the same result on every machine. Source: ITU-T T.871 (JFIF), section 7. Thread:
// pure; concurrent calls on distinct outputs are safe.

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::color {

/// Writes `picture` as kYuv420 of the image's size, which must be even. Reuses fitting memory.
void rgb_to_yuv420(const ColorImage& image, Picture& picture);

/// Resizes `image` to the picture's size and fills it. Requires kYuv420. After rgb_to_yuv420() and
/// this call, a channel's error is at most kRoundTripBound if the colour is constant over 2x2
/// pixels (test Yuv420.RoundTripBound).
void yuv420_to_rgb(const Picture& picture, ColorImage& image);

inline constexpr int kRoundTripBound = 2;

}  // namespace copresence::color
