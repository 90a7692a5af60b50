#include "capture_server/hole_filling/fillable.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace copresence::hole_filling {
namespace {

constexpr std::uint8_t kLongest = 255;  // A run length that stands for 255 and all longer ones.

/// Marks the holes of short column runs, and sets every pixel of `fillable`. A run that touches the
/// image's border counts as longer, by `border` holes. So it is short up to `widest_at_border`
/// holes, and a run from border to border is never short.
void mark_columns(const StateImage& state, int widest, int widest_at_border, Image<std::uint8_t>& fillable) {
  const int width = state.width(), height = state.height();
  const int border = widest - widest_at_border;
  // Per column: length of the run of holes that ends at the present row.
  std::vector<std::uint8_t> run(width, static_cast<std::uint8_t>(border));
  for (int y = 0; y < height; ++y) {
    const DepthState* states = state.row(y).data();
    std::uint8_t *above = run.data(), *out = fillable.row(y).data();
    for (int x = 0; x < width; ++x) {
      const auto longer = static_cast<std::uint8_t>(above[x] + (above[x] != kLongest));
      above[x] = states[x] == DepthState::kHole ? longer : std::uint8_t{0};
      out[x] = above[x];
    }
  }
  if (height > 0) {
    for (std::uint8_t& holes : fillable.row(height - 1)) {
      holes = static_cast<std::uint8_t>(holes == 0 ? 0 : std::min<int>(holes + border, kLongest));
    }
  }
  // The second pass goes upwards. From here on, `run` is the length of the whole run of holes,
  // which is known at the run's lowest pixel.
  std::fill(run.begin(), run.end(), std::uint8_t{0});
  // The loop uses only bytes: with an int, compilers process a quarter as many pixels at a time.
  const auto longest_short = static_cast<std::uint8_t>(widest - 1);
  constexpr std::uint8_t kNo = 0, kYes = 1;
  for (int y = height - 1; y >= 0; --y) {
    std::uint8_t *below = run.data(), *out = fillable.row(y).data();
    for (int x = 0; x < width; ++x) {
      const std::uint8_t length = below[x] != 0 ? below[x] : out[x];
      below[x] = out[x] != 0 ? length : kNo;
      const auto shorter_by_one = static_cast<std::uint8_t>(below[x] - 1);
      out[x] = shorter_by_one <= longest_short ? kYes : kNo;
    }
  }
}

/// The first pixel at or after `x` that is not a hole, or `width` if there is none.
int end_of_run(const DepthState* states, int x, int width) {
  std::uint64_t eight = 0;
  while (x + 8 <= width && (std::memcpy(&eight, states + x, 8), eight == 0)) x += 8;
  while (x < width && states[x] == DepthState::kHole) ++x;
  return x;
}

}  // namespace

void find_fillable(const StateImage& state, int widest, int widest_at_border, Image<std::uint8_t>& fillable) {
  static_assert(static_cast<int>(DepthState::kHole) == 0 && sizeof(DepthState) == 1);
  assert(widest >= 1 && widest < kLongest && widest_at_border >= 0 && 2 * widest_at_border <= widest);
  fillable.resize(state.width(), state.height());
  mark_columns(state, widest, widest_at_border, fillable);
  const int width = state.width();
  for (int y = 0; y < state.height(); ++y) {
    const DepthState* states = state.row(y).data();
    for (int x = 0; x < width;) {
      const void* hole = std::memchr(states + x, 0, static_cast<std::size_t>(width - x));
      if (hole == nullptr) break;
      const int first = static_cast<int>(static_cast<const DepthState*>(hole) - states);
      x = end_of_run(states, first, width);
      const int borders = (first == 0) + (x == width);
      if (borders < 2 && x - first <= (borders == 0 ? widest : widest_at_border)) {
        std::memset(fillable.row(y).data() + first, 1, static_cast<std::size_t>(x - first));
      }
    }
  }
}

}  // namespace copresence::hole_filling
