#pragma once

// Softens silhouette edges, where a near surface ends before a far one (merge_rules.h,
// Silhouettes). Thread: different tiles may be processed at the same time.

#include <algorithm>
#include <cstdint>

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

}  // namespace copresence::renderer
