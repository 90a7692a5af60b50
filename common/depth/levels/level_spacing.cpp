#include "common/depth/levels/level_spacing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "common/depth/levels/codebook.h"

namespace copresence::depth {
namespace {

double steps_between(double from, double to, DepthUnit unit) {
  return (1 / from - 1 / to) / (sensor_step_m(1.0) * metres_per_unit(unit));
}

constexpr double kRare = 1e-4;   // of all pixels: a level with fewer, as its neighbours, is rare
constexpr int kNeighbours = 24;  // levels to either side that count with one
constexpr double kMargin = 60;   // codes left free before the first level, for nearer ones

}  // namespace

std::vector<double> sensor_spacing(std::span<const std::uint16_t> levels, DepthRangeUnits range,
                                   DepthUnit unit) {
  std::vector<double> distance;
  double before = range.near;
  for (const std::uint16_t level : levels) {
    distance.push_back(
        std::max(distance.empty() ? 0.0 : 1.0, std::round(steps_between(before, level, unit))));
    before = level;
  }
  return distance;
}

std::vector<double> scene_spacing(std::span<const std::uint16_t> levels,
                                  std::span<const std::uint32_t> pixels, DepthRangeUnits range,
                                  DepthUnit unit) {
  assert(levels.size() == pixels.size());
  std::vector<double> distance = sensor_spacing(levels, range, unit);
  if (levels.empty()) return distance;
  distance[0] = std::min(distance[0], kMargin);
  const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0);
  std::vector<bool> rare(levels.size());
  // Beyond the last level there are few steps up to the range's end, and scenes turn there often: they get their codes.
  double steps_of_rare = distance[0], steps_of_others = steps_between(levels.back(), range.far, unit);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const std::size_t first = i < kNeighbours ? 0 : i - kNeighbours;
    const std::size_t count = std::min<std::size_t>(2 * kNeighbours + 1, levels.size() - first);
    const auto near = pixels.subspan(first, count);
    rare[i] = std::accumulate(near.begin(), near.end(), 0.0) < kRare * all * static_cast<double>(count);
    (rare[i] ? steps_of_rare : steps_of_others) += distance[i];
  }
  if (steps_of_others <= 0) return distance;
  const double room = Codebook::kCodes - 1 - steps_of_rare;
  const double codes_per_step = std::clamp(room / steps_of_others, 1.0, kFinest);
  for (std::size_t i = 1; i < levels.size(); ++i) distance[i] *= rare[i] ? 1.0 : codes_per_step;
  return distance;
}

}  // namespace copresence::depth
