#include "simulation/scene/noise.h"

#include <algorithm>
#include <cassert>

namespace copresence::simulation {

namespace {

// Number of pixels interpolated at once. The next cell overwrites pixels beyond the end of a cell.
constexpr std::size_t kCellBatch = 8;

}  // namespace

BlobRows::BlobRows(int cell, std::uint32_t seed, int width)
    : cell_(static_cast<std::size_t>(cell)),
      width_(static_cast<std::size_t>(width)),
      weight_((cell_ + kCellBatch - 1) / kCellBatch * kCellBatch),
      columns_(width_ / cell_ + 2),
      values_(columns_.size()),
      above_(width_ + weight_.size()),
      below_(above_.size()) {
  assert(cell >= 2);
  // Interpolation between four independent values reduces their variance. The gain restores it.
  float mean_square = 0;
  for (int i = 0; i < cell; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(cell), w = 1 - t * t * (3 - 2 * t);
    weight_[static_cast<std::size_t>(i)] = w;
    mean_square += (w * w + (1 - w) * (1 - w)) / static_cast<float>(cell);
  }
  // The mean variance of a pixel is mean_square (along x) times mean_square (along y). The gain
  // makes it 1.
  gain_ = 1 / mean_square;
  for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i] = hash(seed, static_cast<std::uint32_t>(i));
  fill_lattice_row(0, below_);
}

void BlobRows::fill_lattice_row(std::uint32_t row, std::vector<float>& out) {
  const std::uint32_t* __restrict columns = columns_.data();
  float* __restrict values = values_.data();
  for (std::size_t i = 0; i < values_.size(); ++i) values[i] = gain_ * normal(hash(columns[i], row));
  for (std::size_t start = 0, i = 0; start < width_; start += cell_, ++i) {
    const float a = values[i], b = values[i + 1];
    for (std::size_t first = 0; first < weight_.size(); first += kCellBatch) {
      const float* __restrict weight = weight_.data() + first;
      float* __restrict blended = out.data() + start + first;
      for (std::size_t x = 0; x < kCellBatch; ++x) blended[x] = b + (a - b) * weight[x];
    }
  }
}

BlobRow BlobRows::next() {
  if (y_ % cell_ == 0) {
    above_.swap(below_);
    fill_lattice_row(static_cast<std::uint32_t>(y_ / cell_ + 1), below_);
  }
  const float weight = weight_[y_++ % cell_];
  return {above_.data(), below_.data(), weight};
}

void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise) {
  BlobRows rows(cell, seed, noise.width());
  for (int y = 0; y < noise.height(); ++y) {
    const BlobRow row = rows.next();
    const std::span<float> out = noise.row(y);
    for (std::size_t x = 0; x < out.size(); ++x) out[x] = row[x];
  }
}

}  // namespace copresence::simulation
