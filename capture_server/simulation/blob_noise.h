#pragma once

// Noise that neighbouring pixels share: normal values on a lattice, smoothly blended between. The image-sized
// counterpart of hash_noise.h. Thread: a free function on values, safe anywhere.

#include <cstdint>

#include "common/frame/image.h"

namespace copresence::simulation {

/// Fills `noise` with blobs of about `cell` pixels: mean 0, standard deviation 1 (on average over the image),
/// a pure function of seed and pixel. Requires cell >= 2.
void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise);

}  // namespace copresence::simulation
