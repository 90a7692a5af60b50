#include "capture_server/simulation/blob_noise.h"

#include <cassert>
#include <vector>

#include "capture_server/simulation/hash_noise.h"

namespace copresence::simulation {

void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise) {
  assert(cell >= 2);
  const int width = noise.width(), height = noise.height();
  const int columns = width / cell + 2;
  // Weights of the left lattice point over one cell, shared by both directions. Blending four independent
  // values shrinks their spread; `gain` gives it back.
  std::vector<float> weight(static_cast<std::size_t>(cell));
  float mean_square = 0;
  for (int i = 0; i < cell; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(cell), w = 1 - t * t * (3 - 2 * t);
    weight[static_cast<std::size_t>(i)] = w;
    mean_square += (w * w + (1 - w) * (1 - w)) / static_cast<float>(cell);
  }
  const float gain = 1 / mean_square;  // the root of the mean of both directions' squares

  const auto lattice_row = [&](int row, std::vector<float>& out) {
    // Hashed values at the lattice, then blended along the row.
    std::vector<float> values(static_cast<std::size_t>(columns));
    for (int i = 0; i < columns; ++i) {
      values[static_cast<std::size_t>(i)] =
          gain * normal(hash(seed, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(row)));
    }
    for (int start = 0, i = 0; start < width; start += cell, ++i) {
      const float a = values[static_cast<std::size_t>(i)], b = values[static_cast<std::size_t>(i) + 1];
      const int end = start + cell < width ? cell : width - start;
      for (int x = 0; x < end; ++x)
        out[static_cast<std::size_t>(start + x)] = b + (a - b) * weight[static_cast<std::size_t>(x)];
    }
  };

  std::vector<float> above(static_cast<std::size_t>(width)), below(static_cast<std::size_t>(width));
  lattice_row(0, below);
  for (int y = 0; y < height; ++y) {
    if (y % cell == 0) {
      above.swap(below);
      lattice_row(y / cell + 1, below);
    }
    const float w = weight[static_cast<std::size_t>(y % cell)];
    float* out = noise.row(y).data();
    for (int x = 0; x < width; ++x) {
      out[x] = below[static_cast<std::size_t>(x)] +
               (above[static_cast<std::size_t>(x)] - below[static_cast<std::size_t>(x)]) * w;
    }
  }
}

}  // namespace copresence::simulation
