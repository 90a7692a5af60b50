#pragma once

// Noise that neighbouring pixels share: normal values on a lattice, smoothly blended between. The image-sized
// counterpart of hash_noise.h. Thread: a free function on values, safe anywhere.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"

namespace copresence::simulation {

/// Fills `noise` with blobs of about `cell` pixels: mean 0, standard deviation 1 (on average over the image),
/// a pure function of seed and pixel. Requires cell >= 2.
void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise);

/// A row of it, blended where it is read: the rows of the lattice above and below.
struct BlobRow {
  const float* above;
  const float* below;
  float weight;  ///< of the one above
  float operator[](std::size_t x) const { return below[x] + (above[x] - below[x]) * weight; }
};

/// The same row by row, from the top: a picture of it need not be kept.
class BlobRows {
 public:
  BlobRows(int cell, std::uint32_t seed, int width);

  /// The next row; its own until the call after.
  BlobRow next();

 private:
  void lattice_row(std::uint32_t row, std::vector<float>& out);

  std::size_t cell_, width_;
  float gain_ = 0;
  std::size_t y_ = 0;
  std::vector<float> weight_;           // of the left lattice point over one cell, shared by both directions
  std::vector<std::uint32_t> columns_;  // of the lattice, hashed
  std::vector<float> values_;           // at a row of the lattice
  std::vector<float> above_, below_;    // the lattice's rows around y_, blended along the row
};

}  // namespace copresence::simulation
