#include "capture_server/hole_filling/joint_filling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "capture_server/hole_filling/fillable.h"
#include "capture_server/hole_filling/filling_rules.h"
#include "capture_server/hole_filling/surface_guess.h"

namespace copresence::hole_filling {
namespace {

float at(const Plane& plane, float dx, float dy) {
  return plane.steps + plane.slope_x * dx + plane.slope_y * dy;
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
  find_fillable(frame.state, kWidestGapPx, fillable_);
  cells_.see(frame.depth, fillable_, steps_times_units_, steps_);
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
  const int width = frame.depth.width(), height = frame.depth.height();
  const int right = std::min(width, (column + 1) * kCellPx), bottom = std::min(height, (row + 1) * kCellPx);
  const float middle_x = static_cast<float>(column * kCellPx) + 0.5f * (kCellPx - 1);
  const float middle_y = static_cast<float>(row * kCellPx) + 0.5f * (kCellPx - 1);
  for (int y = row * kCellPx; y < bottom; ++y) {
    for (int x = column * kCellPx; x < right; ++x) {
      if (fillable_(x, y) == 0) continue;
      const float dx = static_cast<float>(x) - middle_x, dy = static_cast<float>(y) - middle_y;
      const float far = at(guess.far, dx, dy), near = at(guess.near, dx, dy);
      float far_weight = 0, far_rest = 0, near_weight = 0, near_rest = 0, near_x = 0, near_y = 0,
            far_like = 0, near_like = 0;
      for (int v = std::max(0, y - kWindowPx); v <= std::min(height - 1, y + kWindowPx); ++v) {
        for (int u = std::max(0, x - kWindowPx); u <= std::min(width - 1, x + kWindowPx); ++u) {
          const float s = steps_(u, v);
          if (s == 0) continue;
          const float du = static_cast<float>(u - x), dv = static_cast<float>(v - y);
          const float weight = falling((du * du + dv * dv) * 0.25f);
          const float rest = s - far - guess.far.slope_x * du - guess.far.slope_y * dv;
          float like = 1;
          if (color != nullptr && guess.near.steps > 0) {
            const Rgb8 c = (*color)(u, v);
            like = likeness((*color)(x, y), {float(c.r), float(c.g), float(c.b)});
          }
          if (std::abs(rest) <= kSameSurface) {
            far_weight += weight;
            far_rest += weight * rest;
            far_like += weight * like;
          }
          const float rest_near = s - near - guess.near.slope_x * du - guess.near.slope_y * dv;
          if (std::abs(rest_near) <= kSameSurface) {
            near_weight += weight;
            near_rest += weight * rest_near;
            near_x += weight * du;
            near_y += weight * dv;
            near_like += weight * like;
          }
        }
      }
      bool takes_near = false;
      if (guess.near.steps > 0) {
        const bool enclosed = near_weight > 2 * far_weight &&
                              near_x * near_x + near_y * near_y < 0.25f * near_weight * near_weight;
        takes_near = enclosed || (guess.near_surrounds && near_weight >= far_weight);
        if (color != nullptr) {
          const float prior = 0.3f;
          const float l_far =
              (far_like + prior * likeness((*color)(x, y), guess.far_color)) / (far_weight + prior);
          const float l_near =
              (near_like + prior * likeness((*color)(x, y), guess.near_color)) / (near_weight + prior);
          if (l_near > 4 * l_far + 0.2f) takes_near = true;
          if (l_far > 4 * l_near + 0.2f) takes_near = false;
        }
      }
      const float s = takes_near ? near + near_rest / (near_weight + kGuessWeight)
                                 : far + far_rest / (far_weight + kGuessWeight);
      if (!(s > 0)) continue;
      const float units = steps_times_units_ / s + 0.5f;
      if (units < static_cast<float>(range_.near) || units >= static_cast<float>(range_.far) + 1) continue;
      frame.depth(x, y) = static_cast<std::uint16_t>(units);
      frame.state(x, y) = DepthState::kFilled;
    }
  }
}

}  // namespace copresence::hole_filling
