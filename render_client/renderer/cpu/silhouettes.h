#pragma once

// Softens silhouette edges, where a near surface ends before a far one (merge_rules.h,
// Silhouettes). Thread: different tiles may be processed at the same time.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// The silhouette edges of a tile: one byte per row and group of kLanes pixels. The bit of a pixel
/// is set if an edge lies between the pixel and its right neighbour.
using SilhouetteBits = Image<std::uint8_t>;

/// Returns the edge bits of a group of pixels. `here` and `next` are the inverse depths of the
/// nearest fragments of its pixels and of their right neighbours. A value of at most `empty` means
/// that there is no fragment. At an edge, the two inverse depths differ by more than `apart`.
inline std::uint8_t find_silhouettes(const Floats& here, const Floats& next, float empty, float apart) {
  const Floats difference = here - next;
  return static_cast<std::uint8_t>(
      bits(((difference > apart) | (difference < -apart)) & (here > empty) & (next > empty)));
}

/// Mixes the colours of two neighbours. `left_before` is the colour that the left pixel had before
/// it was mixed with its own left neighbour.
inline void soften(Rgba8& left, Rgba8& right, const Rgba8& left_before) {
  const Rgba8 right_before = right;
  const auto mix = [](std::uint8_t& own, std::uint8_t from, std::uint8_t other) {
    own = static_cast<std::uint8_t>(std::clamp(own + (other - from) / kSilhouetteDivisor, 0, 255));
  };
  for (const auto channel : {&Rgba8::r, &Rgba8::g, &Rgba8::b}) {
    mix(left.*channel, left_before.*channel, right_before.*channel);
    mix(right.*channel, right_before.*channel, left_before.*channel);
  }
}

/// Softens the rows of `view` from `top` on. Bits beyond the last column are ignored.
inline void soften_silhouettes(const SilhouetteBits& silhouettes, int top, MergedView& view) {
  for (int row = 0; row < silhouettes.height(); ++row) {
    Rgba8* const pixels = view.color.row(top + row).data();
    const std::uint8_t* const groups = silhouettes.row(row).data();
    // The last pixel that was mixed with its left neighbour, and its colour before mixing.
    int changed_x = -1;
    Rgba8 changed{};
    for (int group = 0; group < silhouettes.width(); ++group) {
      unsigned here = groups[group];
      for (int at = group * kLanes; here != 0 && at + 1 < view.width; ++at, here >>= 1) {
        if (!(here & 1U)) continue;
        const Rgba8 left_before = at == changed_x ? changed : pixels[at];
        changed = pixels[at + 1];
        changed_x = at + 1;
        soften(pixels[at], pixels[at + 1], left_before);
      }
    }
  }
}

/// Softens the edges between the rows of `view` in its columns [left, right). `inverse` has the
/// inverse depths of the nearest fragments, 0 without any. At an edge, two inverse depths differ by
/// more than `apart`. Different columns may be softened at the same time.
inline void soften_between_rows(const Image<float>& inverse, float apart, int left, int right,
                                MergedView& view) {
  // For each column, the colour before mixing of the pixel in the row `changed_row`.
  std::vector<Rgba8> before(static_cast<std::size_t>(right - left));
  std::vector<int> changed_row(before.size(), -1);
  for (int y = 0; y + 1 < view.height; ++y) {
    const float* const here = inverse.row(y).data();
    const float* const below = inverse.row(y + 1).data();
    const auto soften_at = [&](int x) {
      const int column = x - left;
      Rgba8& upper = view.color(x, y);
      const Rgba8 upper_before = changed_row[column] == y ? before[column] : upper;
      before[column] = view.color(x, y + 1);
      changed_row[column] = y + 1;
      soften(upper, view.color(x, y + 1), upper_before);
    };
    int x = left;
    for (; x + kLanes <= right; x += kLanes) {
      unsigned edges = find_silhouettes(load<Floats>(here + x), load<Floats>(below + x), 0, apart);
      for (int at = x; edges != 0; ++at, edges >>= 1) {
        if (edges & 1U) soften_at(at);
      }
    }
    for (; x < right; ++x) {
      if (here[x] > 0 && below[x] > 0 && std::abs(here[x] - below[x]) > apart) soften_at(x);
    }
  }
}

}  // namespace copresence::renderer
