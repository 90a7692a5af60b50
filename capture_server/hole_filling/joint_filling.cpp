#include "capture_server/hole_filling/joint_filling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "capture_server/hole_filling/fillable.h"
#include "capture_server/hole_filling/filling_rules.h"
#include "capture_server/hole_filling/surface_guess.h"

namespace copresence::hole_filling {
namespace {

constexpr int kTilePx = kCellPx + 2 * kWindowPx;  // a cell and what its pixels' windows reach
static_assert(kWindowPx <= Cells::kMarginPx && kWindowPx == 2);
constexpr std::array<float, 5> kKernel{0.37f, 0.78f, 1, 0.78f,
                                       0.37f};  // exp(-d^2 / 4), the window's weights each way

using CellPixels = std::array<std::array<float, kCellPx>, kCellPx>;

/// What the measured pixels in the windows of a cell's pixels say about one surface.
struct Support {
  CellPixels weight;  ///< of those that lie on the surface
  CellPixels rest;    ///< weighted sum of their steps above it
  CellPixels x, y;    ///< weighted sum of where they are, pixels from the window's middle
};

/// Windows are separable, and what a pixel says does not depend on the window it is in: sums along columns,
/// then rows. `corner` is the top left of the cell's tile. Without `places`, x and y stay unset.
void find_support(const float* corner, int stride, const Plane& plane, bool places, Support& support) {
  constexpr float kFirst = -kWindowPx - 0.5f * (kCellPx - 1);  // from the cell's middle
  std::array<std::array<float, kTilePx>, kTilePx> member, rest;
  for (int v = 0; v < kTilePx; ++v) {
    const float start =
        plane.steps + plane.slope_y * (kFirst + static_cast<float>(v)) + plane.slope_x * kFirst;
    for (int u = 0; u < kTilePx; ++u) {
      const float s = corner[v * stride + u];
      const float above = s - (start + plane.slope_x * static_cast<float>(u));
      const bool on_it = std::abs(above) <= kSameSurface && s > 0;
      member[v][u] = on_it ? 1.0f : 0.0f;
      rest[v][u] = on_it ? above : 0.0f;
    }
  }
  for (int y = 0; y < kCellPx; ++y) {
    std::array<float, kTilePx> weights{}, rests{}, places_y{};
    for (int k = 0; k < 5; ++k) {
      const float kernel = kKernel[k], moment = kKernel[k] * static_cast<float>(k - kWindowPx);
      for (int u = 0; u < kTilePx; ++u) {
        weights[u] += kernel * member[y + k][u];
        rests[u] += kernel * rest[y + k][u];
        places_y[u] += moment * member[y + k][u];
      }
    }
    std::array<float, kCellPx> weight{}, rest_sum{}, place_x{}, place_y{};
    for (int k = 0; k < 5; ++k) {
      const float kernel = kKernel[k], moment = kKernel[k] * static_cast<float>(k - kWindowPx);
      for (int x = 0; x < kCellPx; ++x) {
        weight[x] += kernel * weights[x + k];
        rest_sum[x] += kernel * rests[x + k];
      }
      if (!places) continue;
      for (int x = 0; x < kCellPx; ++x) {
        place_x[x] += moment * weights[x + k];
        place_y[x] += kernel * places_y[x + k];
      }
    }
    support.weight[y] = weight;
    support.rest[y] = rest_sum;
    support.x[y] = place_x;
    support.y[y] = place_y;
  }
}

/// exp(-x), near enough, without a table: (1 - x / 8)^8.
float falling(float x) {
  const float a = std::max(0.0f, 1 - x * 0.125f), b = a * a, c = b * b;
  return c * c;
}

float likeness(Rgb8 a, const std::array<float, 3>& b) {
  const float dr = static_cast<float>(a.r) - b[0], dg = static_cast<float>(a.g) - b[1],
              db = static_cast<float>(a.b) - b[2];
  return falling((dr * dr + dg * dg + db * db) * (1 / (2 * kColorSigma * kColorSigma)));
}

}  // namespace

JointFilling::JointFilling(const FrameFormat& format)
    : steps_times_units_(steps_times_units(format.unit)),
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
  const SurfaceGuess guess = guess_surfaces(cells_, column, row, color);
  if (guess.far.steps <= 0) return;
  const bool two = guess.near.steps > 0;
  const int left = column * kCellPx, top = row * kCellPx;
  const float* corner = cells_.steps(left - kWindowPx, top - kWindowPx);
  Support far, near;
  find_support(corner, cells_.pixel_stride(), guess.far, false, far);
  if (two) find_support(corner, cells_.pixel_stride(), guess.near, true, near);

  const int right = std::min(kCellPx, frame.depth.width() - left),
            bottom = std::min(kCellPx, frame.depth.height() - top);
  for (int y = 0; y < bottom; ++y) {
    for (int x = 0; x < right; ++x) {
      if (fillable_(left + x, top + y) == 0) continue;
      const float dx = static_cast<float>(x) - 0.5f * (kCellPx - 1),
                  dy = static_cast<float>(y) - 0.5f * (kCellPx - 1);
      bool takes_near = false;
      if (two) {
        const float W = near.weight[y][x], X = near.x[y][x], Y = near.y[y][x];
        const bool enclosed = W > 2 * far.weight[y][x] && X * X + Y * Y < 0.25f * W * W;
        takes_near = enclosed || (guess.prefers_near && W >= far.weight[y][x]);
        if (color != nullptr) {
          const float like_far = likeness((*color)(left + x, top + y), guess.far_color);
          const float like_near = likeness((*color)(left + x, top + y), guess.near_color);
          if (like_near > 4 * like_far + 0.2f) takes_near = true;
          if (like_far > 4 * like_near + 0.2f) takes_near = false;
        }
      }
      const Plane& plane = takes_near ? guess.near : guess.far;
      const Support& support = takes_near ? near : far;
      const float s = plane.steps + plane.slope_x * dx + plane.slope_y * dy +
                      support.rest[y][x] / (support.weight[y][x] + kGuessWeight);
      if (!(s > 0)) continue;
      const float units = steps_times_units_ / s + 0.5f;
      if (units < static_cast<float>(range_.near) || units >= static_cast<float>(range_.far) + 1) continue;
      frame.depth(left + x, top + y) = static_cast<std::uint16_t>(units);
      frame.state(left + x, top + y) = DepthState::kFilled;
    }
  }
}

}  // namespace copresence::hole_filling
