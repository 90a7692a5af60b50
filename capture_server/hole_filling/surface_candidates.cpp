#include "capture_server/hole_filling/surface_candidates.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "capture_server/hole_filling/filling_rules.h"

namespace copresence::hole_filling {
namespace {

struct Observation {
  float steps, slope_x, slope_y;
  float weight;
  int pixels;       // Number of measured pixels.
  int column, row;  // Position of the cell.
  int direction;    // Direction of the search, or -1 for the cell itself.
};

/// The surfaces observed around a cell. The code avoids branches, which would be unpredictable.
struct Observations {
  static constexpr int kMost = 2 + 2 * 8;
  static constexpr int kLanes = 8;
  static constexpr int kRoom = (kMost / kLanes + 1) * kLanes;
  using Steps = float __attribute__((vector_size(kLanes * sizeof(float))));
  using Numbers = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

  std::array<Observation, kMost + 1> entries;  // The last entry is for rejected observations.
  std::array<float, kRoom> steps;              // Steps of the entries.
  std::array<std::uint8_t, kMost> order;       // Indices of the entries in sorted order.
  int count = 0;
  float farthest = 1e9f, nearest = 0;

  const Observation& operator[](int i) const { return entries[order[i]]; }

  void add(const Observation& observation, bool is_there) {
    entries[count] = observation;
    steps[count] = observation.steps;
    count += is_there;
    farthest = is_there ? std::min(farthest, observation.steps) : farthest;
    nearest = is_there ? std::max(nearest, observation.steps) : nearest;
  }

  /// Sorts the entries from far to near, unless all of them belong to one surface. In that common
  /// case, the order does not matter.
  void find_order() {
    for (int i = 0; i < count; ++i) order[i] = static_cast<std::uint8_t>(i);
    if (nearest - farthest <= kLinked) return;
    // An entry's rank is the number of entries before it. Eight ranks are computed at a time.
    for (int first = 0; first < count; first += kLanes) {
      Steps these;
      std::memcpy(&these, &steps[first], sizeof these);
      const Numbers numbers = first + Numbers{0, 1, 2, 3, 4, 5, 6, 7};
      Numbers places{};
      for (int i = 0; i < count; ++i) places -= (these > steps[i]) | ((these == steps[i]) & (numbers > i));
      for (int lane = 0; lane < std::min(kLanes, count - first); ++lane)
        order[places[lane]] = static_cast<std::uint8_t>(first + lane);
    }
  }
};

/// A run of entries that belong to one surface.
struct Group {
  int begin = 0, end = 0;
  float weight = 0;
  int pixels = 0;
};

/// Weight of one measured pixel of a cell, by the distance of the cell in cells. The first table is
/// for directions along rows and columns, the second for diagonals.
constexpr auto kShares = [] {
  std::array<std::array<float, kReachCells + 1>, 2> shares{};
  for (int reach = 1; reach <= kReachCells; ++reach) {
    const float straight = static_cast<float>(reach), diagonal = straight * 1.41421356f;
    shares[0][reach] = 1.0f / (16.0f * straight * straight);
    shares[1][reach] = 1.0f / (16.0f * diagonal * diagonal);
  }
  return shares;
}();
constexpr float kShareOfItself = 1.0f / (16.0f * 0.6f * 0.6f);

Observations look_around(const Cells& cells, int column, int row) {
  Observations seen;
  const auto add = [&](int cell, int c, int r, float share, int direction) {
    const float dx = static_cast<float>((column - c) * kCellPx), dy = static_cast<float>((row - r) * kCellPx);
    const float sx = cells.slope_x[cell], sy = cells.slope_y[cell];
    const int far_count = cells.far_count[cell], near_count = cells.near_count[cell];
    seen.add({cells.far[cell] + sx * dx + sy * dy, sx, sy, share * static_cast<float>(far_count), far_count,
              c, r, direction},
             far_count > 0);
    seen.add({cells.near[cell] + sx * dx + sy * dy, sx, sy, share * static_cast<float>(near_count),
              near_count, c, r, direction},
             near_count > 0);
  };
  const int cell = cells.at(column, row);
  add(cell, column, row, kShareOfItself, -1);
  for (int d = 0; d < 8; ++d) {
    const int reach = cells.reach[d][cell];
    if (reach == 0) continue;
    const auto [dx, dy] = Cells::kDirections[d];
    add(cell + reach * cells.offset({dx, dy}), column + reach * dx, row + reach * dy,
        kShares[dx != 0 && dy != 0][reach], d);
  }
  return seen;
}

Plane mean_plane(const Observations& seen, const Group& group) {
  Plane plane;
  for (int i = group.begin; i < group.end; ++i) {
    const Observation& s = seen[i];
    plane.steps += s.weight * s.steps;
    plane.slope_x += s.weight * s.slope_x;
    plane.slope_y += s.weight * s.slope_y;
  }
  const float share = 1.0f / group.weight;
  return {plane.steps * share, plane.slope_x * share, plane.slope_y * share};
}

std::array<float, 3> mean_color(const Observations& seen, const Group& group, const ColorImage& color) {
  std::array<float, 3> mean{};
  for (int i = group.begin; i < group.end; ++i) {
    const Observation& s = seen[i];
    const int x = std::min(s.column * kCellPx + 1, color.width() - 1),
              y = std::min(s.row * kCellPx + 1, color.height() - 1);
    const Rgb8 a = color(x, y),
               b = color(std::min(x + 1, color.width() - 1), std::min(y + 1, color.height() - 1));
    const float half = 0.5f * s.weight / group.weight;
    mean[0] += half * static_cast<float>(a.r + b.r);
    mean[1] += half * static_cast<float>(a.g + b.g);
    mean[2] += half * static_cast<float>(a.b + b.b);
  }
  return mean;
}

/// Number of axes, of four, on which the group was observed on both sides of the cell.
int opposite_sides(const Observations& seen, const Group& group) {
  unsigned directions = 0;
  for (int i = group.begin; i < group.end; ++i) {
    if (seen[i].direction >= 0) directions |= 1u << seen[i].direction;
  }
  int axes = 0;
  for (int axis = 0; axis < 4; ++axis) axes += (directions >> (2 * axis) & 3u) == 3u;
  return axes;
}

/// True if the near surface, `steps` in front of the far surface, is close enough to block the
/// projector's light. Both sides count, since pictures may be mirrored.
bool in_shadow(const Observations& seen, const Group& near, float steps, int column, int row) {
  const float reach = kShadowPxPerStep * steps + kShadowSlackPx;
  for (int i = near.begin; i < near.end; ++i) {
    const Observation& s = seen[i];
    if (s.row == row && static_cast<float>((std::abs(s.column - column) - 1) * kCellPx) <= reach) return true;
  }
  return false;
}

}  // namespace

SurfaceCandidates find_surface_candidates(const Cells& cells, int column, int row, const ColorImage* color) {
  Observations seen = look_around(cells, column, row);
  if (seen.count == 0) return {};
  seen.find_order();
  Group far, near, group;
  for (int i = 0; i < seen.count; ++i) {
    group.weight += seen[i].weight;
    group.pixels += seen[i].pixels;
    group.end = i + 1;
    if (i + 1 < seen.count && seen[i + 1].steps - seen[i].steps <= kLinked) continue;
    if (group.pixels >= kWorthPixels) {
      if (far.weight == 0) {
        far = group;
      } else if (group.weight > near.weight) {
        near = group;
      }
    }
    group = {i + 1, i + 1, 0, 0};
  }
  SurfaceCandidates candidates;
  if (far.weight == 0) return candidates;
  candidates.far = mean_plane(seen, far);
  if (near.weight == 0) return candidates;
  candidates.near = mean_plane(seen, near);
  const bool surrounded = opposite_sides(seen, near) >= 2 && opposite_sides(seen, far) == 0;
  const bool shadowed = in_shadow(seen, near, candidates.near.steps - candidates.far.steps, column, row);
  candidates.prefers_near = surrounded || (!shadowed && near.weight > far.weight);
  if (color != nullptr) {
    candidates.far_color = mean_color(seen, far, *color);
    candidates.near_color = mean_color(seen, near, *color);
  }
  return candidates;
}

}  // namespace copresence::hole_filling
