#include "render_client/depth_smoothing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace copresence::client {
namespace {

constexpr int kRadius = DepthSmoothing::kRadius;
constexpr int kRowsAtATime = 32;  // so few stay in a core's second-level cache until they are taken down

/// Means over the taps that lie on the surface of the middle one, for a row of pixels. Tap i of pixel x is
/// `first[i * distance + x]`; 0 is a hole. Written so that compilers take eight pixels at a time.
void mean_of_same_surface(const float* __restrict first, std::size_t distance, float tolerance_per_square,
                          int width, float* __restrict out) {
  const float* __restrict middle = first + kRadius * distance;
  for (int x = 0; x < width; ++x) {
    const float z = middle[x];
    const float tolerance = z * z * tolerance_per_square;
    float sum = z;
    std::int32_t count = 1;
    const auto add = [&](float tap) {
      // All bits or none: choosing by a condition costs twice the steps.
      const std::int32_t on_surface = -static_cast<std::int32_t>(std::abs(tap - z) <= tolerance);
      sum += std::bit_cast<float>(std::bit_cast<std::int32_t>(tap) & on_surface);
      count -= on_surface;
    };
#pragma GCC unroll 8
    for (int i = 1; i <= kRadius; ++i) {
      add(middle[x - i * static_cast<std::ptrdiff_t>(distance)]);
      add(middle[x + i * static_cast<std::ptrdiff_t>(distance)]);
    }
    out[x] = sum / static_cast<float>(count);
  }
}

}  // namespace

void DepthSmoothing::smooth(DepthImage& depth, DepthUnit unit) {
  const int width = depth.width(), height = depth.height();
  const auto row_floats = static_cast<std::size_t>(width);
  // Depth in units: a step is z^2 metres_per_unit / 351.3 of them. A hole, 0, is on no surface but its own.
  const float tolerance_per_square =
      kSameSurface * static_cast<float>(sensor_step_m(1.0) * metres_per_unit(unit));
  padded_.assign(row_floats + 2 * kRadius, 0.0f);
  smoothed_.resize(row_floats);
  rows_.assign(row_floats * (kRowsAtATime + 2 * kRadius), 0.0f);
  // Across, into one of the rows at hand; rows beyond the image are holes.
  const auto smooth_across = [&](int y, std::size_t place) {
    float* const out = rows_.data() + place * row_floats;
    if (y >= height) {
      std::fill_n(out, row_floats, 0.0f);
      return;
    }
    std::copy_n(depth.row(y).data(), width, padded_.data() + kRadius);
    mean_of_same_surface(padded_.data(), 1, tolerance_per_square, width, out);
  };
  for (int y = 0; y < kRadius; ++y) smooth_across(y, kRadius + y);
  for (int top = 0; top < height; top += kRowsAtATime) {
    const int rows = std::min(kRowsAtATime, height - top);
    for (int i = 0; i < rows; ++i) smooth_across(top + kRadius + i, 2 * kRadius + i);
    for (int i = 0; i < rows; ++i) {
      mean_of_same_surface(rows_.data() + i * row_floats, row_floats, tolerance_per_square, width,
                           smoothed_.data());
      std::uint16_t* out = depth.row(top + i).data();
      for (int x = 0; x < width; ++x)
        out[x] = static_cast<std::uint16_t>(smoothed_[static_cast<std::size_t>(x)] + 0.5f);
    }
    std::copy_n(rows_.data() + rows * row_floats, 2 * kRadius * row_floats, rows_.data());
  }
}

}  // namespace copresence::client
