#include "common/depth/spiral_filter.h"

#include <cassert>
#include <cstdlib>

namespace copresence::depth {
namespace {

// In 13-bit codes, about 0.56 mm over the default range.
constexpr int kOff = 128;   // half a period: farther from both sides than this is suspicious
constexpr int kClose = 24;  // an upper part that comes this close to a side is believed

constexpr int kNone = -1;

// The value with the lower bits of `coded` that is nearest to `target`.
int nearest_alias(int coded, int target, bool fold) {
  const int luma = fold && (coded >> 8 & 1) ? 255 - (coded & 255) : coded & 255;
  int best = coded, least = std::abs(coded - target);
  for (int upper = (target >> 8) - 1; upper <= (target >> 8) + 1; ++upper) {
    if (upper < 0 || upper > 31) continue;
    const int alias = upper << 8 | (fold && (upper & 1) ? 255 - luma : luma);
    if (std::abs(alias - target) >= least) continue;
    least = std::abs(alias - target);
    best = alias;
  }
  return best;
}

class Correction {
 public:
  Correction(DepthImage& coded, const StateImage& states, int block, bool fold)
      : coded_(coded), states_(states), block_(block), fold_(fold) {}

  void pixel(int x, int y) const {
    if (states_(x, y) == DepthState::kHole) return;
    const int first_x = x - x % block_, first_y = y - y % block_;
    const int here = coded_(x, y);
    int best = here, least = kClose + 1;
    const auto axis = [&](int before, int behind) {
      const auto agrees = [&](int side) { return side != kNone && std::abs(side - here) <= kOff; };
      if (agrees(before) || agrees(behind)) return;
      for (const int side : {before, behind}) {
        if (side == kNone) continue;
        const int alias = nearest_alias(here, side, fold_), distance = std::abs(alias - side);
        if (distance >= least) continue;
        least = distance;
        best = alias;
      }
    };
    axis(at(first_x - 1, y), at(first_x + block_, y));
    axis(at(x, first_y - 1), at(x, first_y + block_));
    coded_(x, y) = static_cast<std::uint16_t>(best);
  }

 private:
  int at(int x, int y) const {
    const bool inside = x >= 0 && x < coded_.width() && y >= 0 && y < coded_.height();
    return inside && states_(x, y) != DepthState::kHole ? int{coded_(x, y)} : kNone;
  }

  DepthImage& coded_;
  const StateImage& states_;
  const int block_;
  const bool fold_;
};

}  // namespace

void correct_upper_bits(DepthImage& coded, const StateImage& states, const Image<std::uint8_t>& doubtful,
                        bool fold) {
  assert(same_shape(coded, states));
  const int block = coded.width() / doubtful.width();
  assert(doubtful.width() * block == coded.width() && doubtful.height() * block == coded.height());
  const Correction correction(coded, states, block, fold);
  for (int y = 0; y < coded.height(); ++y) {
    const auto doubt = doubtful.row(y / block);
    for (int sample = 0; sample < doubtful.width(); ++sample) {
      if (!doubt[sample]) continue;
      for (int i = 0; i < block; ++i) correction.pixel(sample * block + i, y);
    }
  }
}

}  // namespace copresence::depth
