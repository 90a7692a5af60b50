#include "render_client/renderer/shading.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

// Inverse depth of a cell, 0 without depth, and its slopes per cell.
struct Cell {
  float w = 0, dx = 0, dy = 0;
  bool has_slope = false;
};

// Returns the largest difference of inverse depth between neighbouring cells of one surface.
float most_difference(float w) {
  return kShadedSurface + kShadedSlope * w;
}

Cell mean_of_nearest(const DepthImage& depth, float units_per_metre, int left, int top) {
  const int right = std::min(left + kCell, depth.width()), bottom = std::min(top + kCell, depth.height());
  std::uint16_t nearest = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const std::uint16_t value = depth(x, y);
      if (value > 0 && (nearest == 0 || value < nearest)) nearest = value;
    }
  }
  Cell cell;
  if (nearest == 0) return cell;
  const float nearest_w = units_per_metre / float(nearest), least_w = nearest_w - most_difference(nearest_w);
  int count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      if (depth(x, y) == 0) continue;
      const float w = units_per_metre / float(depth(x, y));
      if (w < least_w) continue;
      cell.w += w;
      ++count;
    }
  }
  cell.w /= float(count);
  return cell;
}

// Calls visit(dx, dy, cell) for the cells around (x, y) that lie on its surface.
template <class Visit>
void for_each_beside(const Image<Cell>& cells, int x, int y, int radius, Visit&& visit) {
  const float w = cells(x, y).w;
  for (int v = std::max(0, y - radius); v <= std::min(y + radius, cells.height() - 1); ++v) {
    for (int u = std::max(0, x - radius); u <= std::min(x + radius, cells.width() - 1); ++u) {
      const Cell& cell = cells(u, v);
      const auto distance = static_cast<float>(std::max(std::abs(u - x), std::abs(v - y)));
      if (cell.w > 0 && std::abs(cell.w - w) <= distance * most_difference(w)) visit(u - x, v - y, cell);
    }
  }
}

void fit(Image<Cell>& cells, int x, int y) {
  Cell& cell = cells(x, y);
  const int radius = std::clamp(static_cast<int>(std::lround(1 / cell.w)), kLeastRadius, kMostRadius);
  float n = 0, su = 0, sv = 0, sw = 0, suu = 0, suv = 0, svv = 0, suw = 0, svw = 0;
  for_each_beside(cells, x, y, radius, [&](int du, int dv, const Cell& beside) {
    const auto u = static_cast<float>(du), v = static_cast<float>(dv);
    n += 1;
    su += u;
    sv += v;
    sw += beside.w;
    suu += u * u;
    suv += u * v;
    svv += v * v;
    suw += u * beside.w;
    svw += v * beside.w;
  });
  const float uu = suu - su * su / n, uv = suv - su * sv / n, vv = svv - sv * sv / n;
  const float uw = suw - su * sw / n, vw = svw - sv * sw / n;
  const float determinant = uu * vv - uv * uv;
  if (determinant < 1) return;
  cell.dx = (uw * vv - vw * uv) / determinant;
  cell.dy = (vw * uu - uw * uv) / determinant;
  cell.has_slope = true;
}

}  // namespace

void measure_shading(const DepthImage& depth, DepthUnit unit, const CameraModel& camera,
                     Image<float>& incidences) {
  const int columns = (depth.width() + kCell - 1) / kCell, rows = (depth.height() + kCell - 1) / kCell;
  const auto units_per_metre = static_cast<float>(1 / metres_per_unit(unit));
  Image<Cell> cells(columns, rows);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      cells(x, y) = mean_of_nearest(depth, units_per_metre, x * kCell, y * kCell);
  }
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (cells(x, y).w > 0) fit(cells, x, y);
    }
  }
  incidences.resize(columns, rows);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const float w = cells(x, y).w;
      float dx = 0, dy = 0, n = 0;
      if (w > 0) {
        for_each_beside(cells, x, y, w * kSharpM > 1 ? 0 : 1, [&](int, int, const Cell& beside) {
          if (!beside.has_slope) return;
          dx += beside.dx;
          dy += beside.dy;
          n += 1;
        });
      }
      const float ray_x = ((static_cast<float>(x) + 0.5F) * kCell - cx) / fx;
      const float ray_y = ((static_cast<float>(y) + 0.5F) * kCell - cy) / fy;
      incidences(x, y) =
          n > 0 ? cos_theta(w, dx / n * fx / kCell, dy / n * fy / kCell, ray_x, ray_y) : kUnknownIncidence;
    }
  }
}

}  // namespace copresence::renderer
