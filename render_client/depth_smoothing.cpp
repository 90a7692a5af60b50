#include "render_client/depth_smoothing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace copresence::client {
namespace {

constexpr int kRadius = DepthSmoothing::kRadius;

/// Means over the taps that lie on the surface of the middle one, for a row of pixels. Tap i of pixel x is
/// `first[i * distance + x]`; 0 is a hole. Written so that compilers take eight pixels at a time.
void mean_of_same_surface(const float* __restrict first, std::size_t distance, float tolerance_per_square,
                          int width, float* __restrict out) {
  const float* __restrict middle = first + kRadius * distance;
  for (int x = 0; x < width; ++x) {
    const float z = middle[x];
    const float tolerance = z * z * tolerance_per_square;
    float sum = z, count = 1.0f;
    const auto add = [&](float tap) {
      const float on_surface = std::abs(tap - z) <= tolerance ? 1.0f : 0.0f;
      sum += on_surface * tap;
      count += on_surface;
    };
#pragma GCC unroll 8
    for (int i = 1; i <= kRadius; ++i) {
      add(middle[x - i * static_cast<std::ptrdiff_t>(distance)]);
      add(middle[x + i * static_cast<std::ptrdiff_t>(distance)]);
    }
    out[x] = sum / count;
  }
}

}  // namespace

void DepthSmoothing::smooth(DepthImage& depth, DepthUnit unit) {
  const int width = depth.width(), height = depth.height();
  const auto row_floats = static_cast<std::size_t>(width);
  // Depth in units: a step is z^2 metres_per_unit / 351.3 of them. A hole, 0, is on no surface but its own.
  const float tolerance_per_square =
      kSameSurface * static_cast<float>(sensor_step_m(1.0) * metres_per_unit(unit));
  rows_.assign(row_floats * (height + 2 * kRadius), 0.0f);
  padded_.assign(row_floats + 2 * kRadius, 0.0f);
  for (int y = 0; y < height; ++y) {
    std::copy_n(depth.row(y).data(), width, padded_.data() + kRadius);
    mean_of_same_surface(padded_.data(), 1, tolerance_per_square, width,
                         rows_.data() + (y + kRadius) * row_floats);
  }
  for (int y = 0; y < height; ++y) {
    mean_of_same_surface(rows_.data() + y * row_floats, row_floats, tolerance_per_square, width,
                         padded_.data());
    std::uint16_t* out = depth.row(y).data();
    for (int x = 0; x < width; ++x)
      out[x] = static_cast<std::uint16_t>(padded_[static_cast<std::size_t>(x)] + 0.5f);
  }
}

}  // namespace copresence::client
