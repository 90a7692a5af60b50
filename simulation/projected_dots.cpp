#include "simulation/projected_dots.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace copresence::simulation {
namespace {

constexpr float kLeastDepth = 0.2f;  // metres; nearer surfaces throw no shadow

}  // namespace

// Along a row a surface at pixel u and depth z lies in the projector's column u - f b / z; what is farther than the nearest
// surface of its column gets no dots. Between neighbouring pixels of one surface the columns are filled.
void project_dots(const CameraModel& model, const TrueView& view, DotImage& dots) {
  assert(view.depth_m.width() == model.width && view.depth_m.height() == model.height);
  const auto shift = static_cast<float>(model.fx * kProjectorBaseline);
  const int margin = static_cast<int>(std::ceil(shift / kLeastDepth)) + 2;
  const int width = model.width;
  constexpr float kFar = 1e9f;
  const auto row_of = [&](auto value) { return std::vector(static_cast<std::size_t>(width), value); };
  std::vector<float> levels = row_of(0.0f), exact_columns = row_of(0.0f);
  std::vector<int> columns = row_of(0);  // rounded down
  std::vector<float> nearest(static_cast<std::size_t>(width + margin) + 2);
  dots.resize(width, model.height);
  float* __restrict level = levels.data();
  float* __restrict exact_column = exact_columns.data();
  int* __restrict column = columns.data();
  float* __restrict near = nearest.data();
  for (int y = 0; y < model.height; ++y) {
    const float* __restrict z = view.depth_m.row(y).data();
    const float* __restrict infrared = view.infrared.row(y).data();
    Dots* __restrict out = dots.row(y).data();
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
      const float inverse = 1 / std::max(z[x], kLeastDepth);
      const float exact = static_cast<float>(x + margin) - shift * inverse;
      exact_column[x] = exact;
      column[x] = static_cast<int>(exact);
      level[x] = static_cast<float>(kLevelConstant) * inverse;
    }
    std::fill(nearest.begin(), nearest.end(), kFar);
    for (int x = 0; x < width; ++x) {
      if (z[x] < kLeastDepth) continue;
      const int last = column[x];
      near[last] = std::min(near[last], z[x]);
      if (x == 0 || last - column[x - 1] <= 1) continue;
      if (exact_column[x] - exact_column[x - 1] <= 1 || std::abs(z[x] - z[x - 1]) >= 0.03f * z[x]) continue;
      for (int c = column[x - 1] + 1; c < last; ++c) near[c] = std::min(near[c], z[x]);
    }
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
      out[x].level = near[column[x]] < z[x] * 0.96f ? 0.0f : level[x];
      out[x].light = infrared[x] * (1.25f - 0.09f * z[x]);
    }
  }
}

}  // namespace copresence::simulation
