#include "render_client/renderer/band.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render_client/renderer/lanes.h"

namespace copresence::renderer {
namespace {

constexpr float kTolerancePx = 1.0F / 64;

using Attributes = float __attribute__((vector_size(16)));  // w, k, u, v of a ViewVertex

Attributes attributes(const ViewVertex& vertex) {
  Attributes a;
  std::memcpy(&a, &vertex.w, sizeof a);
  return a;
}

// An edge's function of the pixel, >= 0 on the inner side of a clockwise triangle and kTolerancePx beyond.
struct Edge {
  float x, y;    // where the edge begins
  float dx, dy;  // to its end
  float tolerance;

  Edge(const ViewVertex& from, const ViewVertex& to)
      : x(from.x),
        y(from.y),
        dx(to.x - from.x),
        dy(to.y - from.y),
        tolerance(kTolerancePx * (std::abs(dx) + std::abs(dy))) {}

  Floats at(const Floats& pixel_x, float pixel_y) const {
    return all(dx * (pixel_y - y) + tolerance) - dy * (pixel_x - x);
  }
};

}  // namespace

void Band::begin(int width, int top, int rows, float far_m, int camera_width, int camera_height) {
  width_ = width;
  top_ = top;
  rows_ = rows;
  row_ = (width + 2 * kLanes - 1) / kLanes * kLanes;
  empty_ = 1.0F / far_m;
  last_u_ = static_cast<float>(kTexelSteps * (camera_width - 1));
  last_v_ = static_cast<float>(kTexelSteps * (camera_height - 1));
  w_.assign(static_cast<std::size_t>(row_) * rows, empty_);
  texel_.resize(w_.size());
}

void Band::draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c) {
  const float bottom =
      std::min(std::max(std::max(a.y, b.y), c.y) + kTolerancePx, static_cast<float>(top_ + rows_ - 1));
  const float top = std::max(std::min(std::min(a.y, b.y), c.y) - kTolerancePx, static_cast<float>(top_));
  const float right =
      std::min(std::max(std::max(a.x, b.x), c.x) + kTolerancePx, static_cast<float>(width_ - 1));
  const float left = std::max(std::min(std::min(a.x, b.x), c.x) - kTolerancePx, 0.0F);
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (!(area > 0) || !(top <= bottom) || !(left <= right)) return;
  const int first_y = static_cast<int>(std::ceil(top)), last_y = static_cast<int>(std::floor(bottom));
  const int first_x = static_cast<int>(std::ceil(left)), last_x = static_cast<int>(std::floor(right));
  if (first_y > last_y || first_x > last_x) return;

  const Edge ab(a, b), bc(b, c), ca(c, a);
  const float per_area = 1.0F / area;
  const Attributes at_a = attributes(a);
  const Attributes to_b = attributes(b) - at_a, to_c = attributes(c) - at_a;
  const Attributes per_x = (to_b * (c.y - a.y) - to_c * (b.y - a.y)) * per_area;
  const Attributes per_y = (to_c * (b.x - a.x) - to_b * (c.x - a.x)) * per_area;
  // In a sliver the tolerance reaches far beyond the corners' depths.
  const float nearest = std::max(std::max(a.w, b.w), c.w);

  for (int y = first_y; y <= last_y; ++y) {
    const auto pixel_y = static_cast<float>(y);
    const Attributes row = at_a + per_y * (pixel_y - a.y);
    float* const depths = w_.data() + offset(y);
    std::uint32_t* const texels = texel_.data() + offset(y);
    for (int x = first_x; x <= last_x; x += kLanes) {
      const Floats pixel_x = ramp() + static_cast<float>(x);
      const Floats inside =
          smaller(smaller(ab.at(pixel_x, pixel_y), bc.at(pixel_x, pixel_y)), ca.at(pixel_x, pixel_y));
      const Floats offset_x = pixel_x - a.x;
      const Floats w = smaller(row[0] + per_x[0] * offset_x, all(nearest));
      const Floats there = load<Floats>(depths + x);
      const Ints wins = (inside >= 0) & (w > there);
      if (bits(wins) == 0) continue;
      const Floats z = 1.0F / (row[1] + per_x[1] * offset_x);
      const Ints u = truncated(smaller(larger((row[2] + per_x[2] * offset_x) * z, Floats{}), all(last_u_)));
      const Ints v = truncated(smaller(larger((row[3] + per_x[3] * offset_x) * z, Floats{}), all(last_v_)));
      store(depths + x, wins ? w : there);
      store(texels + x, wins ? (v << 16 | u) : load<Ints>(texels + x));
    }
  }
}

namespace {

ClipVertex between(const ClipVertex& a, const ClipVertex& b, float t) {
  const auto mix = [t](float p, float q) { return p + (q - p) * t; };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z), mix(a.w, b.w), mix(a.u, b.u), mix(a.v, b.v)};
}

// Cuts a triangle off at the near plane, z = near w, which leaves up to two.
void draw_clipped(const std::array<ClipVertex, 3>& corners, float near_m, Band& band) {
  std::array<ViewVertex, 4> kept{};
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const ClipVertex& here = corners[i];
    const ClipVertex& next = corners[(i + 1) % 3];
    if (here.is_in_front(near_m)) kept[count++] = to_view(here);
    if (here.is_in_front(near_m) != next.is_in_front(near_m)) {
      const float inside_by = here.z - near_m * here.w, next_by = next.z - near_m * next.w;
      ClipVertex cut = between(here, next, inside_by / (inside_by - next_by));
      cut.z = std::max(cut.z, near_m * cut.w);
      if (cut.z > 0) kept[count++] = to_view(cut);
    }
  }
  for (int i = 2; i < count; ++i) band.draw(kept[0], kept[i - 1], kept[i]);
}

}  // namespace

void draw_patch(const DepthMesh& mesh, const DepthMesh::Patch& patch, const PatchExtent& extent,
                const std::vector<ViewVertex>& vertices, const ProjectionMatrix& matrix, float near_m,
                Band& band) {
  const auto draw = [&](std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    const std::size_t first = patch.first_vertex;
    if (extent.in_front) {
      band.draw(vertices[first + a], vertices[first + b], vertices[first + c]);
    } else {
      draw_clipped({project(mesh, first + a, matrix), project(mesh, first + b, matrix),
                    project(mesh, first + c, matrix)},
                   near_m, band);
    }
  };
  for (std::size_t q = patch.first_quad; q < patch.first_quad + patch.quads; ++q) {
    const auto& [a, b, c, d] = mesh.quads[q];
    draw(a, b, d);
    draw(b, c, d);
  }
  for (std::size_t t = patch.first_triangle; t < patch.first_triangle + patch.triangles; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    draw(a, b, c);
  }
}

}  // namespace copresence::renderer
