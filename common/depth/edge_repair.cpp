#include "common/depth/edge_repair.h"

#include <algorithm>
#include <cmath>

namespace copresence::depth {
namespace {

constexpr int kReach = 2;   // Pixels to either side.
constexpr int kBlock = 32;  // Number of pixels that are tested for edges at a time.
// In disparity steps. If the pixels on both sides differ by more than this, they are on two
// surfaces.
constexpr float kEdgeSteps = 10;
// In disparity steps. A flying pixel differs from both sides by more than this.
constexpr float kFlyingSteps = 5;
// A pixel is repaired only if its distance from the nearer side is below this share of the
// difference between the sides.
constexpr float kSureShare = 0.3f;

}  // namespace

EdgeRepair::EdgeRepair(DepthUnit unit, const DepthNoise& noise)
    : steps_per_inverse_unit_(static_cast<float>(1.0 / (noise.step_m(1.0) * metres_per_unit(unit)))) {}

void EdgeRepair::repair(DepthImage& depth) {
  const int width = depth.width(), height = depth.height();
  copy_.resize(static_cast<std::size_t>(width));
  if (width > 2 * kReach) {
    for (int y = 0; y < height; ++y) {
      std::uint16_t* const row = depth.row(y).data();
      std::copy_n(row, width, copy_.begin());
      const std::uint16_t* const old = copy_.data();
      repair_row(row + kReach, old, old + kReach, old + 2 * kReach, width - 2 * kReach);
    }
  }
  // The pass along columns reads rows above that it has already repaired.
  for (int y = kReach; y + kReach < height; ++y) {
    std::uint16_t* const row = depth.row(y).data();
    repair_row(row, depth.row(y - kReach).data(), row, depth.row(y + kReach).data(), width);
  }
}

void EdgeRepair::repair_row(std::uint16_t* row, const std::uint16_t* before, const std::uint16_t* here,
                            const std::uint16_t* behind, int count) const {
  // Without a division, the compiler uses vector instructions. So |a - b| S / (a b) > k is tested
  // as |a - b| S > k a b, where S converts to disparity steps. Most blocks have no edge.
  const float S = steps_per_inverse_unit_;
  for (int first = 0; first < count; first += kBlock) {
    const int end = std::min(first + kBlock, count);
    int edges = 0;
    for (int i = first; i < end; ++i) {
      const float a = before[i], b = behind[i];
      edges |= std::abs(a - b) * S > kEdgeSteps * a * b;
    }
    if (edges == 0) continue;  // `row` already equals `here`.
    for (int i = first; i < end; ++i) {
      const float a = before[i], b = behind[i], c = here[i];
      const float off_a = std::abs(c - a), off_b = std::abs(c - b);
      const bool flying = (std::abs(a - b) * S > kEdgeSteps * a * b) & (off_a * S > kFlyingSteps * a * c) &
                          (off_b * S > kFlyingSteps * b * c);
      const float near_a = off_a * b, near_b = off_b * a;  // Differences in steps, times a b c / S.
      const bool sure = std::min(near_a, near_b) < kSureShare * std::abs(a - b) * c;
      row[i] = flying & sure ? (near_a < near_b ? before[i] : behind[i]) : here[i];
    }
  }
}

}  // namespace copresence::depth
