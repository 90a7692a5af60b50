#include "tools/depth_bench/depth_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace copresence::depth_bench {
namespace {

double step_mm(double z_mm) {
  return kKinectV1Noise.step_m(z_mm * 1e-3) * 1e3;
}

constexpr double kEdgeSteps = 10;   // Smallest distance of two surfaces at an edge.
constexpr double kFlyingSteps = 5;  // A flying pixel is farther than this from both surfaces.
constexpr int kEdgeReach = 2;       // Distance from a pixel to the surfaces on both sides, pixels.

}  // namespace

void DepthError::add(const DepthImage& depth, const StateImage& states, const DepthImage& back,
                     const StateImage& states_back) {
  assert(same_shape(depth, back) && same_shape(depth, states) && same_shape(depth, states_back));
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    flips_ += states.data()[i] != states_back.data()[i];
    if (states.data()[i] != DepthState::kMeasured) continue;
    const double z = depth.data()[i] * mm_per_unit_, error = std::abs(back.data()[i] * mm_per_unit_ - z);
    const double step = step_mm(z), in_steps = error / step;
    ++pixels_;
    sum_mm_ += error;
    sum_mm2_ += error * error;
    sum_steps2_ += in_steps * in_steps;
    max_mm_ = std::max(max_mm_, error);
    beyond_3_steps_ += error > 3 * step + 1;
    beyond_100mm_ += error > 100;
    ++histogram_[std::min(kBins - 1, static_cast<std::size_t>(error / kBin + 0.5))];
    ++steps_[std::min(kBins - 1, static_cast<std::size_t>(in_steps / kBin + 0.5))];
  }
  add_edges(depth, back);
}

void DepthError::add_edges(const DepthImage& depth, const DepthImage& back) {
  for (int y = 0; y < depth.height(); ++y) {
    const auto row = depth.row(y), row_back = back.row(y);
    for (int x = kEdgeReach; x + kEdgeReach < depth.width(); ++x) {
      const double left = row[x - kEdgeReach] * mm_per_unit_, right = row[x + kEdgeReach] * mm_per_unit_;
      if (left == 0 || right == 0 || row[x] == 0) continue;
      const double step = step_mm(std::min(left, right));
      if (std::abs(left - right) < kEdgeSteps * step_mm(std::max(left, right))) continue;
      const double z = row[x] * mm_per_unit_, z_back = row_back[x] * mm_per_unit_;
      const auto is_flying = [&](double at) {
        return std::min(std::abs(at - left) / step_mm(left), std::abs(at - right) / step_mm(right)) >
               kFlyingSteps;
      };
      if (is_flying(z)) continue;  // The original pixel is flying, too.
      ++edges_;
      flying_ += is_flying(z_back) && std::abs(z_back - z) > kFlyingSteps * step;
    }
  }
}

double DepthError::rmse_mm() const {
  return pixels_ ? std::sqrt(sum_mm2_ / static_cast<double>(pixels_)) : 0;
}
double DepthError::rmse_steps() const {
  return pixels_ ? std::sqrt(sum_steps2_ / static_cast<double>(pixels_)) : 0;
}
double DepthError::mae_mm() const {
  return pixels_ ? sum_mm_ / static_cast<double>(pixels_) : 0;
}
double DepthError::percentile_mm(double share) const {
  return percentile(histogram_, share);
}
double DepthError::percentile_steps(double share) const {
  return percentile(steps_, share);
}

double DepthError::percentile(const std::vector<std::uint64_t>& histogram, double share) const {
  const double wanted = share * static_cast<double>(pixels_);
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += histogram[bin];
    if (static_cast<double>(seen) >= wanted) return static_cast<double>(bin) * kBin;
  }
  return 0;
}

}  // namespace copresence::depth_bench
