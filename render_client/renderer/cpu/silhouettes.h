#pragma once

// Softens silhouette edges, where a near surface ends before a far one (merge_rules.h,
// Silhouettes). Thread: different tiles may be processed at the same time.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// The silhouette edges of a tile: one byte per row and group of kLanes pixels. The bit of a pixel
/// is set if an edge lies between the pixel and its neighbour to the right, or below.
using SilhouetteBits = Image<std::uint8_t>;

/// The pixels of a tile's first or last row, before its edges between rows are softened.
struct BorderRow {
  std::vector<float> nearest;  ///< Inverse depths of the nearest fragments, or 0 without any.
  std::vector<Rgba8> color;
};

struct TileBorders {
  BorderRow first, last;
};

/// Returns the edge bits of a group of pixels. `here` and `next` are the inverse depths of the
/// nearest fragments of its pixels and of their neighbours. A value of at most `empty` means that
/// there is no fragment. At an edge, the two inverse depths differ by more than `apart`.
inline std::uint8_t find_silhouettes(const Floats& here, const Floats& next, float empty, float apart) {
  const Floats difference = here - next;
  return static_cast<std::uint8_t>(
      bits(((difference > apart) | (difference < -apart)) & (here > empty) & (next > empty)));
}

/// Mixes the colours of two neighbours. The last two arguments are their colours before they were
/// mixed with other neighbours in the same direction.
inline void soften(Rgba8& one, Rgba8& other, const Rgba8& one_before, const Rgba8& other_before) {
  const auto mix = [](std::uint8_t& own, std::uint8_t from, std::uint8_t to) {
    own = static_cast<std::uint8_t>(std::clamp(own + (to - from) / kSilhouetteDivisor, 0, 255));
  };
  for (const auto channel : {&Rgba8::r, &Rgba8::g, &Rgba8::b}) {
    mix(one.*channel, one_before.*channel, other_before.*channel);
    mix(other.*channel, other_before.*channel, one_before.*channel);
  }
}

/// Softens the edges between the columns of `view`, from the row `top` on. Bits beyond the last
/// column are ignored.
inline void soften_between_columns(const SilhouetteBits& silhouettes, int top, MergedView& view) {
  for (int row = 0; row < silhouettes.height(); ++row) {
    Rgba8* const pixels = view.color.row(top + row).data();
    const std::uint8_t* const groups = silhouettes.row(row).data();
    // The last pixel that was mixed with its left neighbour, and its colour before mixing.
    int changed_x = -1;
    Rgba8 changed{};
    for (int group = 0; group < silhouettes.width(); ++group) {
      for (unsigned edges = groups[group]; edges != 0; edges &= edges - 1) {
        const int x = group * kLanes + std::countr_zero(edges);
        if (x + 1 >= view.width) break;
        const Rgba8 before = x == changed_x ? changed : pixels[x];
        changed = pixels[x + 1];
        changed_x = x + 1;
        soften(pixels[x], pixels[x + 1], before, changed);
      }
    }
  }
}

/// Softens the edges between the rows of a tile of `view` that begins at the row `top`. Bits beyond
/// the last column are ignored. The last row of bits is not used.
inline void soften_between_rows(const SilhouetteBits& silhouettes, int top, MergedView& view) {
  // For each column, the last row that was mixed with the row above, and its colour before mixing.
  std::vector<int> changed_row(static_cast<std::size_t>(view.width), -1);
  std::vector<Rgba8> changed(changed_row.size());
  for (int row = 0; row + 1 < silhouettes.height(); ++row) {
    Rgba8* const upper = view.color.row(top + row).data();
    Rgba8* const lower = view.color.row(top + row + 1).data();
    const std::uint8_t* const groups = silhouettes.row(row).data();
    for (int group = 0; group < silhouettes.width(); ++group) {
      for (unsigned edges = groups[group]; edges != 0; edges &= edges - 1) {
        const int x = group * kLanes + std::countr_zero(edges);
        if (x >= view.width) break;
        const Rgba8 before = changed_row[x] == row ? changed[x] : upper[x];
        changed[x] = lower[x];
        changed_row[x] = row + 1;
        soften(upper[x], lower[x], before, changed[x]);
      }
    }
  }
}

/// Softens the edges between the last row of a tile and the first row of the next tile, which is
/// the row `y` of `view`.
inline void soften_between_tiles(const BorderRow& above, const BorderRow& below, int y, float apart,
                                 MergedView& view) {
  Rgba8* const upper = view.color.row(y - 1).data();
  Rgba8* const lower = view.color.row(y).data();
  for (int left = 0; left < view.width; left += kLanes) {
    const int count = std::min(kLanes, view.width - left);
    unsigned edges = find_silhouettes(load_first<Floats>(&above.nearest[left], count),
                                      load_first<Floats>(&below.nearest[left], count), 0, apart);
    for (; edges != 0; edges &= edges - 1) {
      const int x = left + std::countr_zero(edges);
      soften(upper[x], lower[x], above.color[x], below.color[x]);
    }
  }
}

}  // namespace copresence::renderer
