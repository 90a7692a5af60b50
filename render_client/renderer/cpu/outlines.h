#pragma once

// Softens the outlines of what stands before something else, as merge_rules.h says (Outlines). Private to the CPU
// renderer. Thread: distinct bands are independent.

#include <cstdint>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/merged_view.h"

namespace copresence::renderer {

/// For a band's rows and their groups of kLanes pixels: a bit for every pixel with an outline between it and the next.
using OutlineBits = Image<std::uint8_t>;

/// The outlines of a group. `here` are the nearest fragments' inverse depths, `next` those one pixel further. Where
/// there is no fragment they are at most `empty`. An outline lies between depths more than `apart` from each other.
inline std::uint8_t find_outlines(const Floats& here, const Floats& next, float empty, float apart) {
  const Floats difference = here - next;
  return static_cast<std::uint8_t>(
      bits(((difference > apart) | (difference < -apart)) & (here > empty) & (next > empty)));
}

/// Changes the colours of the rows from `top` on. What lies beyond the view's last column does not count.
void soften_outlines(const OutlineBits& outlines, int top, MergedView& view);

}  // namespace copresence::renderer
