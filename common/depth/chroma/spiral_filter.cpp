#include "common/depth/chroma/spiral_filter.h"

#include <cassert>
#include <cstdlib>

namespace copresence::depth {
namespace {

// Both limits are in 13-bit codes. A code is about 0.56 mm over the default range.
// Half a period. A pixel farther than this from the pixels on both sides may be wrong.
constexpr int kOff = 128;
// Other upper bits are accepted if they bring the pixel within this distance of the pixel on one
// side.
constexpr int kClose = 24;

constexpr int kNone = -1;

// Returns the value nearest to `target` that has the lower bits of `coded`.
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

// One row of pixels, and the rows above and below its chroma samples; null beyond the image.
struct Rows {
  std::uint16_t* here;
  const std::uint16_t *above, *below;
  const DepthState *states, *states_above, *states_below;
  int width;
};

// Returns the value at x of a row beside the chroma sample. Returns kNone for a hole and outside
// the image.
int side(const std::uint16_t* row, const DepthState* states, int x) {
  return row && states[x] != DepthState::kHole ? int{row[x]} : kNone;
}

// Corrects the pixel at x, whose chroma sample has the columns first_x to end_x - 1.
void correct(const Rows& rows, int x, int first_x, int end_x, bool fold) {
  if (rows.states[x] == DepthState::kHole) return;
  const int here = rows.here[x];
  int best = here, least = kClose + 1;
  const auto axis = [&](int before, int behind) {
    const auto agrees = [&](int value) { return value != kNone && std::abs(value - here) <= kOff; };
    if (agrees(before) || agrees(behind)) return;
    for (const int value : {before, behind}) {
      if (value == kNone) continue;
      const int alias = nearest_alias(here, value, fold), distance = std::abs(alias - value);
      if (distance >= least) continue;
      least = distance;
      best = alias;
    }
  };
  axis(first_x > 0 ? side(rows.here, rows.states, first_x - 1) : kNone,
       end_x < rows.width ? side(rows.here, rows.states, end_x) : kNone);
  axis(side(rows.above, rows.states_above, x), side(rows.below, rows.states_below, x));
  rows.here[x] = static_cast<std::uint16_t>(best);
}

}  // namespace

void correct_upper_bits(DepthImage& coded, const StateImage& states, const Image<std::uint8_t>& doubtful,
                        bool fold) {
  assert(same_shape(coded, states));
  const int block = coded.width() / doubtful.width();
  assert(doubtful.width() * block == coded.width() && doubtful.height() * block == coded.height());
  for (int y = 0; y < coded.height(); ++y) {
    const int first_y = y / block * block, end_y = first_y + block;
    const bool has_above = first_y > 0, has_below = end_y < coded.height();
    const Rows rows{coded.row(y).data(),
                    has_above ? coded.row(first_y - 1).data() : nullptr,
                    has_below ? coded.row(end_y).data() : nullptr,
                    states.row(y).data(),
                    has_above ? states.row(first_y - 1).data() : nullptr,
                    has_below ? states.row(end_y).data() : nullptr,
                    coded.width()};
    const auto doubt = doubtful.row(y / block);
    for (int sample = 0; sample < doubtful.width(); ++sample) {
      if (!doubt[sample]) continue;
      const int first_x = sample * block;
      for (int x = first_x; x < first_x + block; ++x) correct(rows, x, first_x, first_x + block, fold);
    }
  }
}

}  // namespace copresence::depth
