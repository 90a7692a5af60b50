#pragma once

// What a perfect camera sees at one instant.
//
// Thread: a value.

#include "common/frame/image.h"

namespace copresence::simulation {

struct TrueView {
  Image<float> depth_m;  ///< along the optical axis at the pixel's centre; 0 where nothing is
  ColorImage color;      ///< sRGB, smoothed over the pixel
  Image<float>
      infrared;  ///< share of a projector's light at the camera that comes back: surface times cosine; 0 to 1
};

}  // namespace copresence::simulation
