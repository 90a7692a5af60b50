#include "capture_server/hole_filling/joint_filling.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "capture_server/hole_filling/fillable.h"
#include "capture_server/hole_filling/filling_rules.h"
#include "capture_server/hole_filling/surface_candidates.h"

namespace copresence::hole_filling {
namespace {

// Width and height of a tile: a cell, and a margin as wide as the radius of a pixel's window.
constexpr int kTilePx = kCellPx + 2 * kWindowPx;
static_assert(kWindowPx <= Cells::kMarginPx && kWindowPx == 2 && kCellPx == 4);
// Weights exp(-d^2 / 4) at the distances d = 2, 1 and 0 pixels from the window's centre.
constexpr std::array<float, 3> kKernel{0.37f, 0.78f, 1};

// A row of a tile and a row of a cell, each in one vector register.
using TileRow = float __attribute__((vector_size(kTilePx * sizeof(float))));
using CellRow = float __attribute__((vector_size(kCellPx * sizeof(float))));
constexpr TileRow kNone{};

template <class Row>
void load(const float* from, Row& row) {
  std::memcpy(&row, from, sizeof(Row));
}

/// For each pixel of a cell: how well the measured pixels around it fit one surface. The sums run
/// over each pixel's window.
struct Support {
  std::array<CellRow, kCellPx> weight;  ///< Total weight of the pixels on the surface.
  std::array<CellRow, kCellPx> rest;  ///< Weighted sum of these pixels' distances from the surface, in steps.
  /// Weighted sums of these pixels' positions, in pixels from the window's centre.
  std::array<CellRow, kCellPx> x, y;
};

/// Returns elements k to k + 3 of a tile's row. For each of a cell's four pixels, this is the
/// neighbour at one offset.
template <int k>
CellRow from(const TileRow& row) {
  return __builtin_shufflevector(row, row, k, k + 1, k + 2, k + 3);
}

/// Weighted sums over each pixel and its four neighbours in the row.
CellRow across(const TileRow& row) {
  return kKernel[0] * (from<0>(row) + from<4>(row)) + kKernel[1] * (from<1>(row) + from<3>(row)) +
         from<2>(row);
}

/// Weighted sums over the same pixels, with each pixel multiplied by its offset.
CellRow first_moment_across(const TileRow& row) {
  return 2 * kKernel[0] * (from<4>(row) - from<0>(row)) + kKernel[1] * (from<3>(row) - from<1>(row));
}

/// Computes the support of a plane for a cell. The sums run along columns first, then along rows,
/// since a pixel's weight does not depend on the window. `corner` is the top left pixel of the
/// cell's tile. `support.x` and `support.y` are set only if `places` is true.
void find_support(const float* corner, int stride, const Plane& plane, bool places, Support& support) {
  // Position of the first column, from the cell's middle.
  constexpr float kFirst = -kWindowPx - 0.5f * (kCellPx - 1);
  constexpr TileRow kColumns{kFirst,     kFirst + 1, kFirst + 2, kFirst + 3,
                             kFirst + 4, kFirst + 5, kFirst + 6, kFirst + 7};
  constexpr TileRow kOne = kNone + 1.0f;
  std::array<TileRow, kTilePx> member, rest;
  for (int v = 0; v < kTilePx; ++v) {
    TileRow s;
    load(corner + v * stride, s);
    const TileRow above =
        s - (plane.steps + plane.slope_y * (kFirst + static_cast<float>(v)) + plane.slope_x * kColumns);
    const auto on_it = (above <= kSameSurface) & (above >= -kSameSurface) & (s > 0.0f);
    member[v] = on_it ? kOne : kNone;
    rest[v] = on_it ? above : kNone;
  }
  for (int y = 0; y < kCellPx; ++y) {
    const auto down = [y](const std::array<TileRow, kTilePx>& rows) {
      return kKernel[0] * (rows[y] + rows[y + 4]) + kKernel[1] * (rows[y + 1] + rows[y + 3]) + rows[y + 2];
    };
    const TileRow weights = down(member), rests = down(rest);
    support.weight[y] = across(weights);
    support.rest[y] = across(rests);
    if (!places) continue;
    support.x[y] = first_moment_across(weights);
    support.y[y] =
        across(2 * kKernel[0] * (member[y + 4] - member[y]) + kKernel[1] * (member[y + 3] - member[y + 1]));
  }
}

/// Approximates exp(-x) by (1 - x / 8)^8, which needs no table.
float falling(float x) {
  const float a = std::max(0.0f, 1 - x * 0.125f), b = a * a, c = b * b;
  return c * c;
}

float likeness(Rgb8 a, const std::array<float, 3>& b) {
  const float dr = static_cast<float>(a.r) - b[0], dg = static_cast<float>(a.g) - b[1],
              db = static_cast<float>(a.b) - b[2];
  return falling((dr * dr + dg * dg + db * db) * (1 / (2 * kColorSigma * kColorSigma)));
}

/// Decides which of two surfaces a pixel lies on, from the weights of both in its window and the
/// centroid of the near surface. `own` is the pixel's colour, or null if it is unknown.
bool lies_near(const SurfaceCandidates& candidates, float far_weight, float near_weight, float near_x,
               float near_y, const Rgb8* own) {
  const bool enclosed =
      near_weight > 2 * far_weight && near_x * near_x + near_y * near_y < 0.25f * near_weight * near_weight;
  const bool by_place = enclosed || (candidates.prefers_near && near_weight >= far_weight);
  if (own == nullptr) return by_place;
  const float like_far = likeness(*own, candidates.far_color),
              like_near = likeness(*own, candidates.near_color);
  if (like_near > 4 * like_far + 0.2f) return true;
  if (like_far > 4 * like_near + 0.2f) return false;
  return by_place;
}

/// Depth of a row of a cell's pixels on `plane`, in units, plus one half for rounding. Where the
/// plane is not in front of the camera, the result lies outside every depth range.
CellRow units_on(const Plane& plane, const Support& support, int y, float steps_times_units) {
  constexpr CellRow kColumns{-1.5f, -0.5f, 0.5f, 1.5f};
  const CellRow s = plane.steps + plane.slope_x * kColumns + plane.slope_y * (static_cast<float>(y) - 1.5f) +
                    support.rest[y] / (support.weight[y] + kCandidateWeight);
  return steps_times_units / s + 0.5f;
}

}  // namespace

JointFilling::JointFilling(const FrameFormat& format)
    : steps_times_units_(steps_times_units(format.unit, format.noise)),
      range_(to_units(format.range, format.unit)),
      cells_(format.width, format.height) {}

Result<void> JointFilling::fill(RgbdFrame& frame) {
  assert(same_shape(frame.depth, frame.state));
  find_fillable(frame.state, kWidestGapPx, kWidestAtBorderPx, fillable_);
  cells_.see(frame.depth, fillable_, steps_times_units_);
  for (int row = 0; row < cells_.rows(); ++row) {
    for (int column = 0; column < cells_.columns(); ++column) {
      if (cells_.wanted[cells_.at(column, row)] != 0) fill_cell(column, row, frame);
    }
  }
  return {};
}

void JointFilling::fill_cell(int column, int row, RgbdFrame& frame) {
  const ColorImage* color = frame.color ? &*frame.color : nullptr;
  const SurfaceCandidates candidates = find_surface_candidates(cells_, column, row, color);
  if (candidates.far.steps <= 0) return;
  const bool two = candidates.near.steps > 0;
  const int left = column * kCellPx, top = row * kCellPx;
  const float* corner = cells_.steps(left - kWindowPx, top - kWindowPx);
  Support far, near;
  find_support(corner, cells_.pixel_stride(), candidates.far, false, far);
  if (two) find_support(corner, cells_.pixel_stride(), candidates.near, true, near);

  const int right = std::min(kCellPx, frame.depth.width() - left),
            bottom = std::min(kCellPx, frame.depth.height() - top);
  const float nearest = range_.near, beyond = static_cast<float>(range_.far) + 1;
  for (int y = 0; y < bottom; ++y) {
    const std::uint8_t* wanted = fillable_.row(top + y).data() + left;
    std::uint16_t* depth = frame.depth.row(top + y).data() + left;
    DepthState* state = frame.state.row(top + y).data() + left;
    const CellRow far_units = units_on(candidates.far, far, y, steps_times_units_);
    const CellRow near_units = two ? units_on(candidates.near, near, y, steps_times_units_) : CellRow{};
    for (int x = 0; x < right; ++x) {
      if (wanted[x] == 0) continue;
      const Rgb8* own = color != nullptr ? color->row(top + y).data() + left + x : nullptr;
      const bool takes_near =
          two && lies_near(candidates, far.weight[y][x], near.weight[y][x], near.x[y][x], near.y[y][x], own);
      const float units = takes_near ? near_units[x] : far_units[x];
      if (!(units >= nearest && units < beyond)) continue;
      depth[x] = static_cast<std::uint16_t>(units);
      state[x] = DepthState::kFilled;
    }
  }
}

}  // namespace copresence::hole_filling
