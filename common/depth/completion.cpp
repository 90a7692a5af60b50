#include "common/depth/completion.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace copresence::depth {

Completion::Completion(int width, int height, DepthRangeUnits range)
    : range_(range), depth_(width, height, 0), states_(width, height, DepthState::kHole) {}

void Completion::take(const DepthImage& depth, const StateImage& states) {
  assert(same_shape(depth, depth_) && same_shape(states, states_));
  const std::size_t size = depth_.pixels().size();
  const auto near = range_.near;
  const auto span = static_cast<std::uint16_t>(range_.far - range_.near);
  const std::uint16_t* const in = depth.data();
  const auto* const state_in = reinterpret_cast<const std::uint8_t*>(states.data());
  std::uint16_t* const out = depth_.data();
  auto* const state_out = reinterpret_cast<std::uint8_t*>(states_.data());
  // In blocks with masks instead of branches, so that the compiler makes vector instructions of it.
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
      out[first + i] = static_cast<std::uint16_t>((in[first + i] & keep[i]) | (out[first + i] & ~keep[i]));
    }
  }
  if (gaps_) fill_along_rows();
}

void Completion::fill_along_rows() {
  const int width = depth_.width(), height = depth_.height();
  int first_full = -1;  // first row that has any depth
  for (int y = 0; y < height; ++y) {
    const auto row = depth_.row(y);
    const auto is_depth = [](std::uint16_t d) { return d != 0; };
    auto at = std::find_if(row.begin(), row.end(), is_depth);
    if (at == row.end()) {
      if (first_full >= 0) std::copy_n(depth_.row(y - 1).begin(), width, row.begin());
      continue;
    }
    if (first_full < 0) first_full = y;
    std::fill(row.begin(), at, *at);
    while (at != row.end()) {
      const auto hole = std::find(at, row.end(), std::uint16_t{0});
      const auto next = std::find_if(hole, row.end(), is_depth);
      if (hole != next) std::fill(hole, next, next == row.end() ? hole[-1] : std::max(hole[-1], *next));
      at = next;
    }
  }
  if (first_full < 0) {
    // Nothing at all: any depth does, but the next frame looks for gaps again.
    std::fill(depth_.pixels().begin(), depth_.pixels().end(), range_.far);
  } else {
    for (int y = first_full - 1; y >= 0; --y)
      std::copy_n(depth_.row(y + 1).begin(), width, depth_.row(y).begin());
  }
  gaps_ = false;
}

}  // namespace copresence::depth
