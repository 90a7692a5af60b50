#include "capture_server/hole_filling/bilateral_filling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "capture_server/hole_filling/filling_rules.h"

namespace copresence::hole_filling {
namespace {

constexpr int kRadius = kBilateralWindowPx;

bool has_hole(std::span<const DepthState> states) {
  return std::find(states.begin(), states.end(), DepthState::kHole) != states.end();
}

}  // namespace

BilateralFilling::BilateralFilling(const FrameFormat& format) : range_(to_units(format.range, format.unit)) {
  for (int i = -kRadius; i <= kRadius; ++i) {
    kernel_.push_back(std::exp(-static_cast<float>(i * i) / (2 * kBilateralSigmaPx * kBilateralSigmaPx)));
  }
  float total = 0;
  for (const float weight : kernel_) total += weight;
  for (float& weight : kernel_) weight /= total;
  column_sum_.resize(format.width + 2 * kRadius);
  column_weight_.resize(format.width + 2 * kRadius);
}

Result<void> BilateralFilling::fill(RgbdFrame& frame) {
  assert(same_shape(frame.depth, frame.state));
  const int width = frame.depth.width(), height = frame.depth.height();
  assert(static_cast<int>(column_sum_.size()) == width + 2 * kRadius);
  const DepthImage measured = frame.depth;
  for (int y = 0; y < height; ++y) {
    const std::span<DepthState> states = frame.state.row(y);
    if (!has_hole(states)) continue;
    std::fill(column_sum_.begin(), column_sum_.end(), 0.0f);
    std::fill(column_weight_.begin(), column_weight_.end(), 0.0f);
    float *sum = column_sum_.data() + kRadius, *weight = column_weight_.data() + kRadius;
    for (int v = std::max(0, y - kRadius); v <= std::min(height - 1, y + kRadius); ++v) {
      const float k = kernel_[v - y + kRadius];
      const std::uint16_t* depths = measured.row(v).data();
      for (int x = 0; x < width; ++x) {
        sum[x] += k * static_cast<float>(depths[x]);
        weight[x] += depths[x] != 0 ? k : 0.0f;
      }
    }
    for (int x = 0; x < width; ++x) {
      if (states[x] != DepthState::kHole) continue;
      float total = 0, total_weight = 0;
      for (int i = -kRadius; i <= kRadius; ++i) {
        total += kernel_[i + kRadius] * sum[x + i];
        total_weight += kernel_[i + kRadius] * weight[x + i];
      }
      if (total_weight < kBilateralEnough) continue;
      // Adding 0.5 and converting to an integer is faster than std::lround().
      const auto mean =
          static_cast<std::uint16_t>(total / total_weight + 0.5f);  // NOLINT(bugprone-incorrect-roundings)
      if (!range_.contains(mean)) continue;
      frame.depth(x, y) = mean;
      states[x] = DepthState::kFilled;
    }
  }
  return {};
}

}  // namespace copresence::hole_filling
