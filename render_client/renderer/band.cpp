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

// Twice the area of the triangle; positive when it is clockwise.
float area(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// A function of the pixel, >= 0 on the inner side of an edge of a clockwise polygon and kTolerancePx beyond.
class Edge {
 public:
  Edge(const ViewVertex& from, const ViewVertex& to)
      : x_(from.x),
        y_(from.y),
        dx_(to.x - from.x),
        dy_(to.y - from.y),
        tolerance_(kTolerancePx * (std::abs(dx_) + std::abs(dy_))) {}

  Floats at(const Floats& x, float y) const { return (dx_ * (y - y_) + tolerance_) - dy_ * (x - x_); }

 private:
  float x_, y_, dx_, dy_, tolerance_;
};

template <std::size_t kEdges>
struct Polygon {
  std::array<Edge, kEdges> edges;

  Floats inside(const Floats& x, float y) const {
    Floats least = edges[0].at(x, y);
    for (std::size_t i = 1; i < kEdges; ++i) least = smaller(least, edges[i].at(x, y));
    return least;
  }
};

// w, k, u and v as affine functions of the pixel.
struct AttributePlane {
  Attributes origin, per_x, per_y;
  float x, y;     // of the origin
  float nearest;  // w of the nearest corner: in a sliver, the outline's tolerance would reach far beyond it

  // p and q are two directions along which the attributes change by P and Q.
  void solve(float p_x, float p_y, const Attributes& P, float q_x, float q_y, const Attributes& Q) {
    const float per_area = 1.0F / (p_x * q_y - p_y * q_x);
    per_x = (P * q_y - Q * p_y) * per_area;
    per_y = (Q * p_x - P * q_x) * per_area;
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

// The pixels that the corners span, as far as they lie in the band.
template <class... Vertices>
bool Band::find_box(Box& box, const Vertices&... corners) const {
  const float bottom =
      std::min(std::max({corners.y...}) + kTolerancePx, static_cast<float>(top_ + rows_ - 1));
  const float top = std::max(std::min({corners.y...}) - kTolerancePx, static_cast<float>(top_));
  if (!(top <= bottom)) return false;
  const float right = std::min(std::max({corners.x...}) + kTolerancePx, static_cast<float>(width_ - 1));
  const float left = std::max(std::min({corners.x...}) - kTolerancePx, 0.0F);
  if (!(left <= right)) return false;
  // All four are within the band and so not negative.
  box = {.left = static_cast<int>(std::ceil(left)),
         .top = static_cast<int>(std::ceil(top)),
         .right = static_cast<int>(right),
         .bottom = static_cast<int>(bottom)};
  return box.left <= box.right && box.top <= box.bottom;
}

template <class Outline, class Plane>
void Band::fill(const Box& box, const Outline& outline, const Plane& plane) {
  for (int y = box.top; y <= box.bottom; ++y) {
    const auto pixel_y = static_cast<float>(y);
    const Attributes row = plane.origin + plane.per_y * (pixel_y - plane.y);
    float* const depths = w_.data() + offset(y);
    std::uint32_t* const texels = texel_.data() + offset(y);
    for (int x = box.left; x <= box.right; x += kLanes) {
      const Floats pixel_x = ramp() + static_cast<float>(x);
      const Floats across = pixel_x - plane.x;
      const Floats w = smaller(row[0] + plane.per_x[0] * across, all(plane.nearest));
      const Floats there = load<Floats>(depths + x);
      const Ints wins = (outline.inside(pixel_x, pixel_y) >= 0) & (w > there);
      if (bits(wins) == 0) continue;
      const Floats z = 1.0F / (row[1] + plane.per_x[1] * across);
      const Ints u =
          truncated(smaller(larger((row[2] + plane.per_x[2] * across) * z, Floats{}), all(last_u_)));
      const Ints v =
          truncated(smaller(larger((row[3] + plane.per_x[3] * across) * z, Floats{}), all(last_v_)));
      store(depths + x, wins ? w : there);
      store(texels + x, wins ? (v << 16 | u) : load<Ints>(texels + x));
    }
  }
}

void Band::draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c) {
  Box box;
  if (!(area(a, b, c) > 0) || !find_box(box, a, b, c)) return;
  AttributePlane plane;
  plane.origin = attributes(a);
  plane.x = a.x;
  plane.y = a.y;
  plane.nearest = std::max(std::max(a.w, b.w), c.w);
  plane.solve(b.x - a.x, b.y - a.y, attributes(b) - plane.origin, c.x - a.x, c.y - a.y,
              attributes(c) - plane.origin);
  fill(box, Polygon<3>{{Edge(a, b), Edge(b, c), Edge(c, a)}}, plane);
}

void Band::draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, const ViewVertex& d) {
  Box box;
  if (!find_box(box, a, b, c, d)) return;
  if (!(area(a, b, d) > 0) || !(area(b, c, d) > 0) || !(area(a, b, c) > 0) || !(area(a, c, d) > 0)) {
    draw(a, b, d);
    draw(b, c, d);
    return;
  }
  AttributePlane plane;
  const Attributes at_a = attributes(a), at_b = attributes(b), at_c = attributes(c), at_d = attributes(d);
  plane.origin = (at_a + at_b + at_c + at_d) * 0.25F;
  plane.x = (a.x + b.x + c.x + d.x) * 0.25F;
  plane.y = (a.y + b.y + c.y + d.y) * 0.25F;
  plane.nearest = std::max(std::max(a.w, b.w), std::max(c.w, d.w));
  plane.solve(c.x - a.x, c.y - a.y, at_c - at_a, d.x - b.x, d.y - b.y, at_d - at_b);
  fill(box, Polygon<4>{{Edge(a, b), Edge(b, c), Edge(c, d), Edge(d, a)}}, plane);
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
  const std::size_t first = patch.first_vertex;
  const auto triangle = [&](std::uint16_t a, std::uint16_t b, std::uint16_t c) {
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
    if (extent.in_front) {
      band.draw(vertices[first + a], vertices[first + b], vertices[first + c], vertices[first + d]);
    } else {
      triangle(a, b, d);
      triangle(b, c, d);
    }
  }
  for (std::size_t t = patch.first_triangle; t < patch.first_triangle + patch.triangles; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    triangle(a, b, c);
  }
}

}  // namespace copresence::renderer
