#pragma once

// Chooses the value that the four pixels of one chroma sample share in 4:2:0. If the pixels lie on
// two surfaces, their mean would be a third depth. Therefore the mean of the majority is used.
// Thread: pure.

#include <algorithm>
#include <array>
#include <cstdint>

#include "common/frame/image.h"

namespace copresence::depth {

/// Finds the largest set of pixels in the 2x2 block at (x, y) that differ from one of its members
/// by at most `tolerance`. Returns the mean of this set. Holes count only if all four pixels are
/// holes. Requires even x and y, and tolerance >= 0.
inline int agreed_value(const DepthImage& depth, const StateImage& states, int x, int y, int tolerance) {
  const std::uint16_t* const upper = depth.row(y).data() + x;
  const std::uint16_t* const lower = depth.row(y + 1).data() + x;
  const std::array<int, 4> value{upper[0], upper[1], lower[0], lower[1]};
  const int least = std::min(std::min(value[0], value[1]), std::min(value[2], value[3]));
  const int most = std::max(std::max(value[0], value[1]), std::max(value[2], value[3]));
  if (most - least <= tolerance) return (value[0] + value[1] + value[2] + value[3] + 2) / 4;

  const DepthState* const above = states.row(y).data() + x;
  const DepthState* const below = states.row(y + 1).data() + x;
  const std::array<bool, 4> hole{above[0] == DepthState::kHole, above[1] == DepthState::kHole,
                                 below[0] == DepthState::kHole, below[1] == DepthState::kHole};
  const bool all_holes = hole[0] && hole[1] && hole[2] && hole[3];
  int best_votes = 0, best = 0;
  for (int i = 0; i < 4; ++i) {
    if (hole[i] && !all_holes) continue;
    int votes = 0, sum = 0;
    for (int k = 0; k < 4; ++k) {
      if ((hole[k] && !all_holes) || std::abs(value[k] - value[i]) > tolerance) continue;
      ++votes;
      sum += value[k];
    }
    if (votes <= best_votes) continue;
    best_votes = votes;
    best = (sum + votes / 2) / votes;
  }
  return best;
}

}  // namespace copresence::depth
