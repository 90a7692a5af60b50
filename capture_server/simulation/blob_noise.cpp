#include "capture_server/simulation/blob_noise.h"

#include <algorithm>
#include <cassert>

#include "capture_server/simulation/hash_noise.h"

namespace copresence::simulation {

BlobRows::BlobRows(int cell, std::uint32_t seed, int width)
    : cell_(cell),
      seed_(seed),
      weight_(static_cast<std::size_t>(cell)),
      values_(static_cast<std::size_t>(width / cell + 2)),
      above_(static_cast<std::size_t>(width)),
      below_(above_.size()),
      row_(above_.size()) {
  assert(cell >= 2);
  // Blending four independent values shrinks their spread; the gain gives it back.
  float mean_square = 0;
  for (int i = 0; i < cell; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(cell), w = 1 - t * t * (3 - 2 * t);
    weight_[static_cast<std::size_t>(i)] = w;
    mean_square += (w * w + (1 - w) * (1 - w)) / static_cast<float>(cell);
  }
  gain_ = 1 / mean_square;  // the root of the mean of both directions' squares
  lattice_row(0, below_);
}

void BlobRows::lattice_row(std::uint32_t row, std::vector<float>& out) {
  for (std::size_t i = 0; i < values_.size(); ++i)
    values_[i] = gain_ * normal(hash(seed_, static_cast<std::uint32_t>(i), row));
  for (std::size_t start = 0, i = 0; start < out.size(); start += weight_.size(), ++i) {
    const float a = values_[i], b = values_[i + 1];
    const std::size_t count = std::min(weight_.size(), out.size() - start);
    for (std::size_t x = 0; x < count; ++x) out[start + x] = b + (a - b) * weight_[x];
  }
}

std::span<const float> BlobRows::next() {
  if (y_ % cell_ == 0) {
    above_.swap(below_);
    lattice_row(static_cast<std::uint32_t>(y_ / cell_ + 1), below_);
  }
  const float w = weight_[static_cast<std::size_t>(y_ % cell_)];
  const float* __restrict above = above_.data();
  const float* __restrict below = below_.data();
  float* __restrict row = row_.data();
  for (std::size_t x = 0; x < row_.size(); ++x) row[x] = below[x] + (above[x] - below[x]) * w;
  ++y_;
  return row_;
}

void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise) {
  BlobRows rows(cell, seed, noise.width());
  for (int y = 0; y < noise.height(); ++y) std::ranges::copy(rows.next(), noise.row(y).data());
}

}  // namespace copresence::simulation
