#include "capture_server/hole_filling/surface_guess.h"

#include <algorithm>
#include <cmath>

#include "capture_server/hole_filling/filling_rules.h"

namespace copresence::hole_filling {
namespace {

struct Sighting {
  float steps, slope_x, slope_y;
  float weight;
  int pixels;       // measured
  int column, row;  // where it was seen
  int direction;    // -1: in the cell itself
};

struct Sightings {
  std::array<Sighting, 2 + 2 * 8> entries;
  int count = 0;
  float farthest = 1e9f, nearest = 0;

  void add(const Sighting& sighting) {
    entries[count++] = sighting;
    farthest = std::min(farthest, sighting.steps);
    nearest = std::max(nearest, sighting.steps);
  }

  /// From far to near. Where everything belongs to one surface, the common case, the order does not matter.
  void sort() {
    if (nearest - farthest <= kLinked) return;
    std::sort(entries.begin(), entries.begin() + count,
              [](const Sighting& a, const Sighting& b) { return a.steps < b.steps; });
  }
};

/// A run of entries that belong to one surface.
struct Group {
  int begin = 0, end = 0;
  float weight = 0;
  int pixels = 0;
};

Sightings look_around(const Cells& cells, int column, int row) {
  Sightings seen;
  const auto add = [&](int cell, int c, int r, float distance_cells, int direction) {
    const float share = 1.0f / (16.0f * distance_cells * distance_cells);
    const float dx = static_cast<float>((column - c) * kCellPx), dy = static_cast<float>((row - r) * kCellPx);
    const float sx = cells.slope_x[cell], sy = cells.slope_y[cell];
    if (cells.far_count[cell] > 0) {
      seen.add({cells.far[cell] + sx * dx + sy * dy, sx, sy, share * cells.far_count[cell],
                cells.far_count[cell], c, r, direction});
    }
    if (cells.near_count[cell] > 0) {
      seen.add({cells.near[cell] + sx * dx + sy * dy, sx, sy, share * cells.near_count[cell],
                cells.near_count[cell], c, r, direction});
    }
  };
  const int cell = cells.at(column, row);
  add(cell, column, row, 0.6f, -1);
  for (int d = 0; d < 8; ++d) {
    const int reach = cells.reach[d][cell];
    if (reach == 0) continue;
    const auto [dx, dy] = Cells::kDirections[d];
    const float distance = static_cast<float>(reach) * (dx != 0 && dy != 0 ? 1.41421356f : 1.0f);
    add(cell + reach * cells.offset({dx, dy}), column + reach * dx, row + reach * dy, distance, d);
  }
  return seen;
}

Plane mean_plane(const Sightings& seen, const Group& group) {
  Plane plane;
  for (int i = group.begin; i < group.end; ++i) {
    const Sighting& s = seen.entries[i];
    plane.steps += s.weight * s.steps;
    plane.slope_x += s.weight * s.slope_x;
    plane.slope_y += s.weight * s.slope_y;
  }
  const float share = 1.0f / group.weight;
  return {plane.steps * share, plane.slope_x * share, plane.slope_y * share};
}

std::array<float, 3> mean_color(const Sightings& seen, const Group& group, const ColorImage& color) {
  std::array<float, 3> mean{};
  for (int i = group.begin; i < group.end; ++i) {
    const Sighting& s = seen.entries[i];
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

/// Axes, of the four, at both of whose ends the group was seen.
int opposite_sides(const Sightings& seen, const Group& group) {
  unsigned directions = 0;
  for (int i = group.begin; i < group.end; ++i) {
    if (seen.entries[i].direction >= 0) directions |= 1u << seen.entries[i].direction;
  }
  int axes = 0;
  for (int axis = 0; axis < 4; ++axis) axes += (directions >> (2 * axis) & 3u) == 3u;
  return axes;
}

/// Whether the near surface, `steps` before the far one, stands close enough beside the cell to keep the
/// sensor's projector from lighting it. Either side, since pictures may be mirrored.
bool in_shadow(const Sightings& seen, const Group& near, float steps, int column, int row) {
  const float reach = kShadowPxPerStep * steps + kShadowSlackPx;
  for (int i = near.begin; i < near.end; ++i) {
    const Sighting& s = seen.entries[i];
    if (s.row == row && static_cast<float>((std::abs(s.column - column) - 1) * kCellPx) <= reach) return true;
  }
  return false;
}

}  // namespace

SurfaceGuess guess_surfaces(const Cells& cells, int column, int row, const ColorImage* color) {
  Sightings seen = look_around(cells, column, row);
  if (seen.count == 0) return {};
  seen.sort();
  Group far, near, group;
  for (int i = 0; i < seen.count; ++i) {
    group.weight += seen.entries[i].weight;
    group.pixels += seen.entries[i].pixels;
    group.end = i + 1;
    if (i + 1 < seen.count && seen.entries[i + 1].steps - seen.entries[i].steps <= kLinked) continue;
    if (group.pixels >= kWorthPixels) {
      if (far.weight == 0) {
        far = group;
      } else if (group.weight > near.weight) {
        near = group;
      }
    }
    group = {i + 1, i + 1, 0, 0};
  }
  SurfaceGuess guess;
  if (far.weight == 0) return guess;
  guess.far = mean_plane(seen, far);
  if (near.weight == 0) return guess;
  guess.near = mean_plane(seen, near);
  const bool surrounded = opposite_sides(seen, near) >= 2 && opposite_sides(seen, far) == 0;
  const bool shadowed = in_shadow(seen, near, guess.near.steps - guess.far.steps, column, row);
  guess.prefers_near = surrounded || (!shadowed && near.weight > far.weight);
  if (color != nullptr) {
    guess.far_color = mean_color(seen, far, *color);
    guess.near_color = mean_color(seen, near, *color);
  }
  return guess;
}

}  // namespace copresence::hole_filling
