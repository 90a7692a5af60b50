#include "common/depth/levels/codebook.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace copresence::depth {
namespace {

// Parameters of scene_spacing(). A level is rare if it and its 24 neighbours on each side have on
// average less than this share of all pixels.
constexpr double kRare = 1e-4;
constexpr int kNeighbours = 24;
constexpr double kMargin = 60;  // Free codes before the first level, for nearer levels.
constexpr double kNearer = 40;  // Codes before nearest_double() in double_spacing().

}  // namespace

Codebook::Codebook(DepthRangeUnits range, DepthUnit unit, const DepthNoise& noise)
    : range_(range),
      steps_per_inverse_unit_(1.0 / (noise.step_m(1.0) * metres_per_unit(unit))),
      levels_(kCodes, 0) {
  assert(range.near >= 1 && range.near < range.far);
}

double Codebook::steps(double from, double to) const {
  return steps_per_inverse_unit_ * (1 / from - 1 / to);
}

int Codebook::count() const {
  return static_cast<int>(kCodes - std::count(levels_.begin(), levels_.end(), std::uint16_t{0}));
}

std::vector<double> Codebook::sensor_spacing(std::span<const std::uint16_t> levels) const {
  std::vector<double> distance;
  double before = range_.near;
  for (const std::uint16_t level : levels) {
    distance.push_back(std::max(distance.empty() ? 0.0 : 1.0, std::round(steps(before, level))));
    before = level;
  }
  return distance;
}

std::vector<double> Codebook::scene_spacing(std::span<const std::uint16_t> levels,
                                            std::span<const std::uint32_t> pixels) const {
  assert(levels.size() == pixels.size());
  std::vector<double> distance = sensor_spacing(levels);
  if (levels.empty()) return distance;
  distance[0] = std::min(distance[0], kMargin);
  const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0);
  std::vector<bool> rare(levels.size());
  // Steps beyond the last level do not count as rare: they are few, and scenes often need them
  // later.
  double steps_of_rare = distance[0], steps_of_others = steps(levels.back(), range_.far);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const std::size_t first = i < kNeighbours ? 0 : i - kNeighbours;
    const std::size_t count = std::min<std::size_t>(2 * kNeighbours + 1, levels.size() - first);
    const auto near = pixels.subspan(first, count);
    rare[i] = std::accumulate(near.begin(), near.end(), 0.0) < kRare * all * static_cast<double>(count);
    (rare[i] ? steps_of_rare : steps_of_others) += distance[i];
  }
  if (steps_of_others <= 0) return distance;
  const double room = kCodes - 1 - steps_of_rare;
  const double codes_per_step = std::clamp(room / steps_of_others, 1.0, kFinest);
  for (std::size_t i = 1; i < levels.size(); ++i) distance[i] *= rare[i] ? 1.0 : codes_per_step;
  return distance;
}

std::vector<double> Codebook::even_spacing(std::span<const std::uint16_t> levels) const {
  const double codes_per_step = std::min(kEven, (kCodes - 1) / steps(range_.near, range_.far));
  std::vector<double> distance;
  double before = 0;  // Code of the previous level.
  for (const std::uint16_t level : levels) {
    const double even = codes_per_step * steps(range_.near, level);
    const double code = distance.empty() ? even : std::max(before + 1, even);
    distance.push_back(code - before);
    before = code;
  }
  return distance;
}

double Codebook::nearest_double() const {
  const double most_steps = (kCodes - 1 - kNearer) / kEven;
  return std::max<double>(range_.near, 1 / (1.0 / range_.far + most_steps / steps_per_inverse_unit_));
}

std::vector<double> Codebook::double_spacing(std::span<const std::uint16_t> levels) const {
  const double nearest = nearest_double();
  std::vector<double> distance;
  double before = range_.near;
  for (const std::uint16_t level : levels) {
    // Numbers of codes before and after nearest_double().
    const double squeezed = before < nearest ? kNearer * steps(before, std::min<double>(level, nearest)) /
                                                   steps(range_.near, nearest)
                                             : 0.0;
    const double full = level > nearest ? kEven * std::round(steps(std::max(before, nearest), level)) : 0.0;
    distance.push_back(std::max(distance.empty() ? 0.0 : 1.0, squeezed + full));
    before = level;
  }
  return distance;
}

void Codebook::assign(std::span<const std::uint16_t> levels, std::span<const double> distance) {
  assert(levels.size() <= kCodes && levels.size() == distance.size());
  assert(std::is_sorted(levels.begin(), levels.end()));
  std::fill(levels_.begin(), levels_.end(), std::uint16_t{0});
  // Wanted number of free codes before each level: the distance minus the level's own code.
  const auto wanted = [&](std::size_t i) { return std::max(0.0, i == 0 ? distance[i] : distance[i] - 1); };
  double all_wanted = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) all_wanted += wanted(i);
  const auto room = static_cast<double>(kCodes - levels.size());
  const double share = all_wanted > room ? room / all_wanted : 1.0;
  double free_codes = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    free_codes += wanted(i) * share;
    levels_[i + std::min(static_cast<std::size_t>(free_codes + 1e-6), kCodes - levels.size())] = levels[i];
  }
}

void Codebook::assign_evenly(DepthRangeUnits range) {
  assert(range_.contains(range.near) && range_.contains(range.far));
  std::fill(levels_.begin(), levels_.end(), std::uint16_t{0});
  const double near = 1.0 / range.near, far = 1.0 / range.far;
  std::uint16_t last = 0;
  for (int code = 0; code < kCodes; ++code) {
    const double z = 1 / (near + (far - near) * code / (kCodes - 1));
    const auto level = static_cast<std::uint16_t>(std::lround(std::clamp<double>(z, range.near, range.far)));
    if (level > last) levels_[code] = last = level;
  }
}

// Returns the code at which a level belongs between two codes: evenly in 1/z between their levels.
// Before the first level and after the last, the spacing of the outermost levels is extrapolated.
int Codebook::place(std::uint16_t level, int below, int above) const {
  if (below < 0 && above == kCodes) return static_cast<int>(std::lround(steps(range_.near, level)));
  if (below < 0)
    return above - static_cast<int>(std::lround(steps(level, levels_[above]) * density(above, 1)));
  if (above == kCodes)
    return below + static_cast<int>(std::lround(steps(levels_[below], level) * density(below, -1)));
  const double t = steps(levels_[below], level) / steps(levels_[below], levels_[above]);
  return below + static_cast<int>(std::lround(t * (above - below)));
}

// Returns the codes per step between an outermost level and the tenth level inwards.
double Codebook::density(int outermost, int direction) const {
  int inner = outermost;
  for (int found = 0, code = outermost + direction; code >= 0 && code < kCodes && found < 10;
       code += direction) {
    if (levels_[code] == 0) continue;
    inner = code;
    ++found;
  }
  if (inner == outermost) return 1;
  return std::max(1.0, std::abs(inner - outermost) / std::abs(steps(levels_[outermost], levels_[inner])));
}

bool Codebook::insert(std::uint16_t level) {
  assert(range_.contains(level));
  int below = -1, above = kCodes;  // Codes of the neighbours.
  for (int code = 0; code < kCodes; ++code) {
    if (levels_[code] == 0) continue;
    assert(levels_[code] != level);
    if (levels_[code] < level) {
      below = code;
    } else {
      above = code;
      break;
    }
  }
  if (above - below > 1) {
    levels_[std::clamp(place(level, below, above), below + 1, above - 1)] = level;
    return true;
  }
  // No code is free between the neighbours, so the levels up to the nearest free code move by one.
  int free_below = below, free_above = above;
  while (free_below >= 0 && levels_[free_below] != 0) --free_below;
  while (free_above < kCodes && levels_[free_above] != 0) ++free_above;
  if (free_below < 0 && free_above == kCodes) return false;
  if (free_above == kCodes || (free_below >= 0 && below - free_below <= free_above - above)) {
    std::move(levels_.begin() + free_below + 1, levels_.begin() + below + 1, levels_.begin() + free_below);
    levels_[below] = level;
  } else {
    std::move_backward(levels_.begin() + above, levels_.begin() + free_above,
                       levels_.begin() + free_above + 1);
    levels_[above] = level;
  }
  return true;
}

std::vector<std::uint16_t> Codebook::depth_of_code() const {
  std::vector<std::uint16_t> depth(kCodes, range_.far);
  int last = -1;
  for (int code = 0; code < kCodes; ++code) {
    if (levels_[code] == 0) continue;
    depth[code] = levels_[code];
    for (int between = last + 1; between < code; ++between) {
      if (last < 0) {
        depth[between] = levels_[code];
        continue;
      }
      const double t = static_cast<double>(between - last) / (code - last);
      depth[between] =
          static_cast<std::uint16_t>(std::lround(1 / ((1 - t) / levels_[last] + t / levels_[code])));
    }
    last = code;
  }
  if (last >= 0) std::fill(depth.begin() + last + 1, depth.end(), levels_[last]);
  return depth;
}

}  // namespace copresence::depth
