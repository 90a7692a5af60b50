#include "common/depth/background_fill.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace copresence::depth {

namespace {

// In disparity steps. A hole is filled again if its value differs from the depth beside it by more
// than this plus the difference between the depths at its two ends. A lower limit costs bits in
// static scenes, where borders flicker. A higher limit costs bits in moving scenes.
constexpr double kCliffSteps = 10;

// A pixel has moved if it changed by more than this many steps. If more than half of all pixels
// have moved, all holes are filled again.
constexpr double kMovedSteps = 2.5;
constexpr std::size_t kSampling = 37;  // Tests every 37th pixel; an odd number avoids a bias to columns.

}  // namespace

BackgroundFill::BackgroundFill(int width, int height, DepthRangeUnits range, DepthUnit unit,
                               const DepthNoise& noise)
    : range_(range),
      steps_per_inverse_unit_(1.0 / (noise.step_m(1.0) * metres_per_unit(unit))),
      depth_(width, height, range.far),
      earlier_(width, height, range.far),
      states_(width, height, DepthState::kHole) {}

double BackgroundFill::steps(int from, int to) const {
  return steps_per_inverse_unit_ * std::abs(from - to) / (static_cast<double>(from) * to);
}

void BackgroundFill::take(const DepthImage& depth, const StateImage& states) {
  assert(same_shape(depth, depth_) && same_shape(states, states_));
  const std::size_t size = depth_.pixels().size();
  const auto near = range_.near;
  const auto span = static_cast<std::uint16_t>(range_.far - range_.near);
  const std::uint16_t* const in = depth.data();
  const auto* const state_in = reinterpret_cast<const std::uint8_t*>(states.data());
  std::swap(depth_, earlier_);
  const std::uint16_t* const old = earlier_.data();
  std::uint16_t* const out = depth_.data();
  auto* const state_out = reinterpret_cast<std::uint8_t*>(states_.data());
  // Blocks and masks instead of branches let the compiler use vector instructions.
  constexpr std::size_t kBlock = 64;
  std::array<std::uint16_t, kBlock> keep;
  for (std::size_t first = 0; first < size; first += kBlock) {
    const std::size_t count = std::min(kBlock, size - first);
    for (std::size_t i = 0; i < count; ++i) {
      const bool inside = static_cast<std::uint16_t>(in[first + i] - near) <= span;
      keep[i] = static_cast<std::uint16_t>(-static_cast<int>(inside & (state_in[first + i] != 0)));
    }
    for (std::size_t i = 0; i < count; ++i) {
      state_out[first + i] = static_cast<std::uint8_t>(state_in[first + i] & keep[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      out[first + i] = static_cast<std::uint16_t>((in[first + i] & keep[i]) | (old[first + i] & ~keep[i]));
    }
  }
  const bool all = first_ || moves_fast();
  visit_gaps([&](const Gap& gap) {
    if (all || has_cliffs(gap)) fill_anew(gap);
  });
  if (first_) fill_rows_without_depth();
}

template <class Visit>
void BackgroundFill::visit_gaps(const Visit& visit) const {
  const int width = states_.width();
  for (int y = 0; y < states_.height(); ++y) {
    const auto* const row = reinterpret_cast<const std::uint8_t*>(states_.row(y).data());
    for (int end = 0; end < width;) {
      const void* const hole = std::memchr(row + end, 0, static_cast<std::size_t>(width - end));
      if (!hole) break;
      Gap gap{y, static_cast<int>(static_cast<const std::uint8_t*>(hole) - row), 0};
      for (end = gap.from; end < width && row[end] == 0;) ++end;
      gap.end = end;
      if (gap.from > 0 || gap.end < width) visit(gap);
    }
  }
}

void BackgroundFill::fill_anew(const Gap& gap) {
  const auto row = depth_.row(gap.y);
  const std::uint16_t left = gap.from > 0 ? row[gap.from - 1] : 0;
  const std::uint16_t right = gap.end < depth_.width() ? row[gap.end] : 0;
  std::fill(row.begin() + gap.from, row.begin() + gap.end, std::max(left, right));
}

bool BackgroundFill::has_cliffs(const Gap& gap) const {
  const auto row = depth_.row(gap.y);
  const bool left = gap.from > 0, right = gap.end < depth_.width();
  double cliffs = left && right ? -steps(row[gap.from - 1], row[gap.end]) : 0;
  if (left) cliffs += steps(row[gap.from - 1], row[gap.from]);
  if (right) cliffs += steps(row[gap.end - 1], row[gap.end]);
  return cliffs > kCliffSteps;
}

bool BackgroundFill::moves_fast() const {
  const std::uint16_t* const now = depth_.data();
  const std::uint16_t* const before = earlier_.data();
  // Test steps(now, before) > kMovedSteps without a division for every pixel.
  const auto reach = static_cast<std::int64_t>(steps_per_inverse_unit_ / kMovedSteps);
  std::size_t seen = 0, moved = 0;
  for (std::size_t i = 0; i < depth_.pixels().size(); i += kSampling) {
    if (states_.data()[i] == DepthState::kHole) continue;
    ++seen;
    moved += std::abs(now[i] - before[i]) * reach > std::int64_t{now[i]} * before[i];
  }
  return moved * 2 > seen;
}

// Copies the row above into rows that never had depth. Empty rows at the top copy the row below.
void BackgroundFill::fill_rows_without_depth() {
  const auto has_depth = [&](int y) {
    const auto row = states_.row(y);
    return std::any_of(row.begin(), row.end(), [](DepthState state) { return state != DepthState::kHole; });
  };
  int first_with = 0;
  while (first_with < depth_.height() && !has_depth(first_with)) ++first_with;
  if (first_with == depth_.height())
    // If no pixel has depth, the next frame is treated as the first frame.
    return;
  const auto copy_row = [&](int from, int to) {
    std::copy_n(depth_.row(from).begin(), depth_.width(), depth_.row(to).begin());
  };
  for (int y = first_with - 1; y >= 0; --y) copy_row(y + 1, y);
  for (int y = first_with + 1; y < depth_.height(); ++y) {
    if (!has_depth(y)) copy_row(y - 1, y);
  }
  first_ = false;
}

}  // namespace copresence::depth
