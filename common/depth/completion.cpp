#include "common/depth/completion.h"

#include <algorithm>
#include <cassert>

namespace copresence::depth {

Completion::Completion(int width, int height, DepthRangeUnits range)
    : range_(range), depth_(width, height, 0), states_(width, height, DepthState::kHole) {}

void Completion::take(const DepthImage& depth, const StateImage& states) {
  assert(same_shape(depth, depth_) && same_shape(states, states_));
  const std::uint16_t near = range_.near, far = range_.far;
  const std::size_t size = depth_.pixels().size();
  const std::uint16_t* const in = depth.data();
  const auto* const state_in = reinterpret_cast<const std::uint8_t*>(states.data());
  std::uint16_t* const out = depth_.data();
  auto* const state_out = reinterpret_cast<std::uint8_t*>(states_.data());
  // Two plain loops: each turns into a few vector instructions per 32 bytes.
  for (std::size_t i = 0; i < size; ++i) {
    const bool valid = (in[i] >= near) & (in[i] <= far);
    state_out[i] = valid ? state_in[i] : std::uint8_t{0};
  }
  for (std::size_t i = 0; i < size; ++i) out[i] = state_out[i] ? in[i] : out[i];
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
