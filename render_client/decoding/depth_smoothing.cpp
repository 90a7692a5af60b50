#include "render_client/decoding/depth_smoothing.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace copresence::decoding {
namespace {

constexpr int kRadius = DepthSmoothing::kRadius;
// These rows stay in the second-level cache between the two passes.
constexpr int kRowsAtATime = 32;

// The sum of the differences to all neighbours must fit into 16 bits. Only depth beyond a Kinect's
// range reaches this limit.
constexpr float kMostTolerance = std::numeric_limits<std::int16_t>::max() / (2 * kRadius);

/// Differences wrap modulo 2^16. Without this limit, a hole or a much nearer neighbour could look
/// as if it were slightly farther.
constexpr float kFarthest = std::numeric_limits<std::uint16_t>::max();

void find_tolerances(const std::uint16_t* __restrict depth, float per_square, int width,
                     std::uint16_t* __restrict out) {
  for (int x = 0; x < width; ++x) {
    const auto z = static_cast<float>(depth[x]);
    const float most = std::min(kMostTolerance, kFarthest - z);
    out[x] = static_cast<std::uint16_t>(static_cast<int>(std::min(z * z * per_square, most)));
  }
}

// Sixteen pixels, in vector types of GCC and clang.
constexpr int kLanes = 16;
using Depths = std::uint16_t __attribute__((vector_size(kLanes * sizeof(std::uint16_t))));
using Numbers = std::int16_t __attribute__((vector_size(kLanes * sizeof(std::int16_t))));

void load(const std::uint16_t* from, Depths& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}
void store(const Numbers& lanes, std::int16_t* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

/// For each pixel of a row, `sums` gets the sum of the differences to the n neighbours within its
/// tolerance. `shares` gets 2^15 / (n + 1). Neighbour i of pixel x is `first[i * distance + x]`. A
/// hole has depth 0 and tolerance 0. The function works on whole groups of kLanes pixels.
void sum_same_surface(const std::uint16_t* first, std::size_t distance, const std::uint16_t* tolerance,
                      std::size_t width, std::int16_t* sums, std::int16_t* shares) {
  const std::uint16_t* const middle = first + kRadius * distance;
  for (std::size_t x = 0; x < width; x += kLanes) {
    Depths z, most;
    load(middle + x, z);
    load(tolerance + x, most);
    Numbers sum{}, taps{};
    for (std::size_t i = 0; i <= 2 * kRadius; ++i) {
      if (i == kRadius) continue;
      Depths tap;
      load(first + i * distance + x, tap);
      const auto off = reinterpret_cast<Numbers>(tap - z);
      const Numbers on_surface = reinterpret_cast<Depths>(off < 0 ? -off : off) <= most;
      sum += off & on_surface;
      taps -= on_surface;
    }
    Numbers share{};  // It stays 0 for a pixel without neighbours.
    constexpr std::array<std::int16_t, 7> kShares{0, 16384, 10923, 8192, 6554, 5461, 4681};
    for (std::int16_t count = 1; count <= 2 * kRadius; ++count)
      share |= (Numbers{} + kShares[count]) & (taps == count);
    store(sum, sums + x);
    store(share, shares + x);
  }
}

/// Computes out = middle + sums * shares / 2^15, rounded.
void add_means(const std::uint16_t* __restrict middle, const std::int16_t* __restrict sums,
               const std::int16_t* __restrict shares, int width, std::uint16_t* __restrict out) {
  for (int x = 0; x < width; ++x) {
    const auto off = static_cast<std::int16_t>((((std::int32_t{sums[x]} * shares[x]) >> 14) + 1) >> 1);
    out[x] = static_cast<std::uint16_t>(middle[x] + off);
  }
}

}  // namespace

void DepthSmoothing::smooth(DepthImage& depth, DepthUnit unit, const DepthNoise& noise) {
  const int width = depth.width(), height = depth.height();
  // A sensor step at depth z is z^2 * step_m(1) * metres_per_unit, in depth units.
  const float tolerance_per_square =
      kSameSurface * static_cast<float>(noise.step_m(1.0) * metres_per_unit(unit));
  // Rows are padded to whole groups of kLanes pixels.
  const auto row_pixels = static_cast<std::size_t>((width + kLanes - 1) / kLanes * kLanes);
  padded_.assign(row_pixels + 2 * kRadius, 0);
  rows_.assign(row_pixels * (kRowsAtATime + 2 * kRadius), 0);
  tolerances_.resize(row_pixels);
  sums_.resize(row_pixels);
  shares_.resize(row_pixels);
  const auto smooth_row = [&](const std::uint16_t* first, std::size_t distance, std::uint16_t* out) {
    const std::uint16_t* const middle = first + kRadius * distance;
    find_tolerances(middle, tolerance_per_square, width, tolerances_.data());
    sum_same_surface(first, distance, tolerances_.data(), row_pixels, sums_.data(), shares_.data());
    add_means(middle, sums_.data(), shares_.data(), width, out);
  };
  // Smooths row y of the image into row `place` of rows_. Rows outside the image consist of holes.
  const auto smooth_across = [&](int y, std::size_t place) {
    std::uint16_t* const out = rows_.data() + place * row_pixels;
    if (y >= height) {
      std::fill_n(out, row_pixels, std::uint16_t{0});
      return;
    }
    std::copy_n(depth.row(y).data(), width, padded_.data() + kRadius);
    smooth_row(padded_.data(), 1, out);
  };
  for (int y = 0; y < kRadius; ++y) smooth_across(y, kRadius + y);
  for (int top = 0; top < height; top += kRowsAtATime) {
    const int rows = std::min(kRowsAtATime, height - top);
    for (int i = 0; i < rows; ++i) smooth_across(top + kRadius + i, 2 * kRadius + i);
    for (int i = 0; i < rows; ++i)
      smooth_row(rows_.data() + i * row_pixels, row_pixels, depth.row(top + i).data());
    std::copy_n(rows_.data() + rows * row_pixels, 2 * kRadius * row_pixels, rows_.data());
  }
}

}  // namespace copresence::decoding
