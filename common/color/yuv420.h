#pragma once

// Colour as a video codec carries it, and back: full-range BT.601 (the JPEG matrix), chroma halved both ways.
//
// Chroma is the mean over 2x2 pixels and is given back to all four of them, so a picture whose colour is
// constant over each 2x2 block makes the round trip to within rounding, and greys make it exactly. Source:
// ITU-T T.871 (JFIF), section 7, in integer arithmetic: one result on every machine. Thread: pure; concurrent
// calls on distinct outputs are safe.

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::color {

/// `picture` becomes kYuv420 of the image's size; it keeps its memory where it has that shape already.
/// Requires even sizes.
void rgb_to_yuv420(const ColorImage& image, Picture& picture);

/// `image` takes the picture's size. A channel is off by at most kRoundTripBound after rgb_to_yuv420() where
/// the colour is constant over 2x2 pixels (Yuv420.RoundTripBound). Requires kYuv420.
void yuv420_to_rgb(const Picture& picture, ColorImage& image);

inline constexpr int kRoundTripBound = 2;

}  // namespace copresence::color
