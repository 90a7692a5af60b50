#include "render_client/moving_surfaces/motion_detector.h"

#include <algorithm>

namespace copresence::moving_surfaces {

void MotionDetector::begin(DepthUnit unit, const DepthNoise& noise) {
  // Depths a and b differ by |a - b| / (a b) in inverse depth.
  limit_ = static_cast<float>(kSteps * noise.inverse_step() * metres_per_unit(unit));
  last_ = {};
  moving_ = {};
}

const MovingBlocks& MotionDetector::detect(const DepthImage& depth) {
  shift_ = block_shift(depth.width());
  const int across = depth.width() >> shift_, down = depth.height() >> shift_;
  if (last_.width() != depth.width() || last_.height() != kRows * down) {
    last_ = DepthImage(depth.width(), kRows * down);
    remaining_ = Image<std::uint8_t>(across, down);
  }
  changes_.resize(static_cast<std::size_t>(depth.width()));
  const int spacing = (1 << shift_) / kRows;
  int moving = 0;
  for (int j = 0; j < down; ++j) {
    std::fill(changes_.begin(), changes_.end(), std::uint8_t{0});
    for (int r = 0; r < kRows; ++r)
      compare_row(depth.row((j << shift_) + r * spacing + spacing / 2).data(),
                  last_.row(kRows * j + r).data());
    moving += count_changes(j);
  }
  if (static_cast<float>(moving) > kCameraMoves * static_cast<float>(across * down))
    std::fill(remaining_.pixels().begin(), remaining_.pixels().end(), std::uint8_t{0});
  widen();
  return moving_;
}

void MotionDetector::compare_row(const std::uint16_t* depth, std::uint16_t* last) {
  const auto width = static_cast<int>(changes_.size());
  std::uint8_t* const changes = changes_.data();
  const float limit = limit_;
  // The loop has no branches, so that the compiler can vectorise it.

#pragma GCC ivdep
  for (int x = 0; x < width; ++x) {
    const int now = depth[x], before = last[x];
    const int is_known = (now > 0) & (before > 0);
    const auto difference = static_cast<float>(now > before ? now - before : before - now);
    const int is_changed = difference > limit * static_cast<float>(now) * static_cast<float>(before);
    changes[x] = static_cast<std::uint8_t>(changes[x] + (is_changed & is_known));
    last[x] = static_cast<std::uint16_t>(now > 0 ? now : before);
  }
}

// Updates the blocks of a row. Returns how many of them move in this frame.
int MotionDetector::count_changes(int block_row) {
  const int size = 1 << shift_;
  const float fewest = kChangedShare * static_cast<float>(kRows * size);
  int moving = 0;
  for (int i = 0; i < remaining_.width(); ++i) {
    int changed = 0;
    for (int x = i * size; x < (i + 1) * size; ++x) changed += changes_[static_cast<std::size_t>(x)];
    std::uint8_t& remaining = remaining_(i, block_row);
    const bool moves = static_cast<float>(changed) >= fewest;
    moving += moves;
    remaining = static_cast<std::uint8_t>(moves ? kFrames : std::max(remaining - 1, 0));
  }
  return moving;
}

// Writes the moving blocks and their neighbours.
void MotionDetector::widen() {
  const auto blocks = remaining_.pixels();
  if (std::none_of(blocks.begin(), blocks.end(), [](std::uint8_t frames) { return frames > 0; })) {
    moving_ = {};
    return;
  }
  const int across = remaining_.width(), down = remaining_.height();
  moving_ = MovingBlocks(across, down);
  for (int j = 0; j < down; ++j) {
    for (int i = 0; i < across; ++i) {
      if (remaining_(i, j) == 0) continue;
      for (int v = std::max(j - 1, 0); v <= std::min(j + 1, down - 1); ++v)
        for (int u = std::max(i - 1, 0); u <= std::min(i + 1, across - 1); ++u) moving_(u, v) = 1;
    }
  }
}

}  // namespace copresence::moving_surfaces
