#include "tools/calibrate/alignment/static_depth.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace copresence::alignment {
namespace {

// Metres: a depth z is kSteps / z disparity steps.
constexpr auto kSteps = static_cast<float>(kKinectV1Noise.disparity_constant_m);
constexpr float kStill = 2.5f;  // steps around the median

}  // namespace

Image<float> static_depth(std::span<const DepthImage> frames, DepthUnit unit) {
  assert(!frames.empty());
  const auto metres = static_cast<float>(metres_per_unit(unit));
  Image<float> mean(frames[0].width(), frames[0].height());
  std::vector<float> steps;
  for (std::size_t pixel = 0; pixel < mean.pixels().size(); ++pixel) {
    steps.clear();
    for (const DepthImage& frame : frames) {
      assert(same_shape(frame, frames[0]));
      if (const std::uint16_t depth = frame.data()[pixel]) {
        steps.push_back(kSteps / (metres * static_cast<float>(depth)));
      }
    }
    if (steps.empty() || 2 * steps.size() < frames.size()) continue;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const float median = *middle;
    float sum = 0;
    std::size_t still = 0;
    for (const float value : steps) {
      if (std::abs(value - median) > kStill) continue;
      sum += value;
      ++still;
    }
    if (5 * still < 4 * steps.size()) continue;
    mean.data()[pixel] = kSteps * static_cast<float>(still) / sum;
  }
  return mean;
}

double measured_share(std::span<const DepthImage> frames) {
  std::size_t measured = 0, all = 0;
  for (const DepthImage& frame : frames) {
    all += frame.pixels().size();
    measured += frame.pixels().size() -
                static_cast<std::size_t>(std::count(frame.pixels().begin(), frame.pixels().end(), 0));
  }
  return all ? static_cast<double>(measured) / static_cast<double>(all) : 0;
}

double unsteady_share(std::span<const DepthImage> frames, const Image<float>& mean) {
  std::size_t measured = 0, unsteady = 0;
  for (std::size_t pixel = 0; pixel < mean.pixels().size(); ++pixel) {
    const auto seen = static_cast<std::size_t>(std::count_if(
        frames.begin(), frames.end(), [pixel](const DepthImage& frame) { return frame.data()[pixel] != 0; }));
    if (seen == 0 || 2 * seen < frames.size()) continue;
    ++measured;
    unsteady += mean.data()[pixel] == 0;
  }
  return measured ? static_cast<double>(unsteady) / static_cast<double>(measured) : 0;
}

}  // namespace copresence::alignment
