#include "render_client/renderer/cpu/tile.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render_client/renderer/cpu/lanes.h"

namespace copresence::renderer {
namespace {
constexpr float kTolerancePx = 1.0F / 64;
}

// The edge functions of a clockwise polygon. An edge function of the pixel is >= 0 on the inner
// side of its edge, and up to kTolerancePx beyond the edge.
template <int kEdges>
class Tile::Polygon {
 public:
  explicit Polygon(const std::array<const ViewVertex*, kEdges>& corners) {
    for (int i = 0; i < kEdges; ++i) {
      const ViewVertex& from = *corners[i];
      const ViewVertex& to = *corners[(i + 1) % kEdges];
      dx_[i] = to.x - from.x;
      dy_[i] = to.y - from.y;
      // In a view of 4096 pixels, the rounding error of a product is 1 % of the tolerance.
      constant_[i] = kTolerancePx * (std::abs(dx_[i]) + std::abs(dy_[i])) - dx_[i] * from.y + dy_[i] * from.x;
    }
  }

  /// inside() returns the smallest edge function at a pixel. Arguments: column() and row().
  template <class X>
  std::array<X, kEdges> column(const X& x) const {
    std::array<X, kEdges> result;
    for (int i = 0; i < kEdges; ++i) result[i] = -dy_[i] * x;
    return result;
  }
  template <class Y>
  std::array<Y, kEdges> row(const Y& y) const {
    std::array<Y, kEdges> result;
    for (int i = 0; i < kEdges; ++i) result[i] = constant_[i] + dx_[i] * y;
    return result;
  }
  template <class Row>
  static Floats inside(const std::array<Floats, kEdges>& column, const std::array<Row, kEdges>& row) {
    Floats least = column[0] + row[0];
    for (int i = 1; i < kEdges; ++i) least = smaller(least, column[i] + row[i]);
    return least;
  }

 private:
  std::array<float, kEdges> constant_, dx_, dy_;
};

// The attributes w, k, u and v as affine functions of the pixel.
struct Tile::AttributePlane {
  Attributes origin, per_x, per_y;
  float x, y;  // The pixel at which the attributes are `origin`.
  // The inverse depth w of the nearest corner. It limits w, which may be far too large beyond the
  // edges of a very thin polygon.
  float nearest;

  // Sets the gradients, given that the attributes change by P along the vector p and by Q along q.
  void solve(float p_x, float p_y, const Attributes& P, float q_x, float q_y, const Attributes& Q) {
    const float per_area = 1.0F / (p_x * q_y - p_y * q_x);
    per_x = (P * q_y - Q * p_y) * per_area;
    per_y = (Q * p_x - P * q_x) * per_area;
  }
};

namespace {

Attributes attributes(const ViewVertex& vertex) {
  Attributes a;
  std::memcpy(&a, &vertex.w, sizeof a);
  return a;
}

Attributes place(const ViewVertex& vertex) {
  Attributes a;
  std::memcpy(&a, &vertex.x, sizeof a);
  return a;
}

// Returns twice the area of the triangle, positive if it is clockwise.
float area(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace

void Tile::begin(int width, int top, int rows, float far_m, int camera_width, int camera_height) {
  const int row = (width + 2 * kLanes - 1) / kLanes * kLanes;
  const std::size_t size = static_cast<std::size_t>(row) * (rows + 1);
  const float empty = 1.0F / far_m;
  if (row == row_ && size == w_.size() && empty == empty_) {
    // Most of a tile is often empty already, and a layer's tile fills much of the cache.
    if (left_ < right_) {
      for (float* at = w_.data(); at < w_.data() + size; at += row) std::fill(at + left_, at + right_, empty);
    }
  } else {
    w_.assign(size, empty);
    texel_.resize(size);
  }
  width_ = width;
  top_ = top;
  rows_ = rows;
  row_ = row;
  left_ = width;
  right_ = 0;
  empty_ = empty;
  last_u_ = static_cast<float>(kTexelSteps * (camera_width - 1));
  last_v_ = static_cast<float>(kTexelSteps * (camera_height - 1));
}

void Tile::give_way_to(const Tile& other) {
  const int left = std::max(left_, other.left_), right = std::min(right_, other.right_);
  for (int y = top_; y < top_ + rows_; ++y) {
    float* __restrict const own = w_.data() + offset(y);
    const float* __restrict const before = other.depths(y);
    for (int x = left; x < right; ++x) own[x] = before[x] > empty_ ? empty_ : own[x];
  }
}

bool Tile::find_box(const Attributes& least, const Attributes& most, Box& box) const {
  const float bottom = std::min(most[1] + kTolerancePx, static_cast<float>(top_ + rows_ - 1));
  const float top = std::max(least[1] - kTolerancePx, static_cast<float>(top_));
  if (!(top <= bottom)) return false;
  const float right = std::min(most[0] + kTolerancePx, static_cast<float>(width_ - 1));
  const float left = std::max(least[0] - kTolerancePx, 0.0F);
  if (!(left <= right)) return false;
  // The four numbers lie within the tile, so they are not negative.
  box = {.left = static_cast<int>(std::ceil(left)),
         .top = static_cast<int>(std::ceil(top)),
         .right = static_cast<int>(right),
         .bottom = static_cast<int>(bottom)};
  return box.left <= box.right && box.top <= box.bottom;
}

// Writes those of eight fragments that are inside the polygon and nearer than earlier fragments.
// `row` and `across` give their attributes. Lanes 0 to 3 are written to `depths` and `texels`, and
// lanes 4 to 7 to `depths + second_half` and `texels + second_half`.
template <class Row>
void Tile::keep(const Floats& inside, const AttributePlane& plane, const Row& row, const Floats& across,
                float* depths, std::uint32_t* texels, std::ptrdiff_t second_half) const {
  const auto at = [&](int i) { return row[i] + plane.per_x[i] * across; };
  const Floats w = smaller(at(0), all(plane.nearest));
  const Floats there = load_halves<Floats>(depths, second_half);
  const Ints wins = (inside >= 0) & (w > there);
  if (bits(wins) == 0) return;
  const Floats z = 1.0F / at(1);
  const Ints u = truncated(smaller(larger(at(2) * z, Floats{}), all(last_u_)));
  const Ints v = truncated(smaller(larger(at(3) * z, Floats{}), all(last_v_)));
  store_halves(depths, second_half, wins ? w : there);
  store_halves(texels, second_half, wins ? (v << 16 | u) : load_halves<Ints>(texels, second_half));
}

template <int kEdges>
void Tile::fill(const Box& box, const Polygon<kEdges>& polygon, const AttributePlane& plane) {
  left_ = std::min(left_, box.left);
  right_ = std::max(right_, box.right + 1);
  float* depths = w_.data() + offset(box.top) + box.left;
  std::uint32_t* texels = texel_.data() + offset(box.top) + box.left;
  const auto left = static_cast<float>(box.left);
  if (box.right - box.left < kLanes / 2) {
    // The box is at most four pixels wide, as for most quads of a fine mesh. So two rows are drawn
    // at a time. The second row may lie below the box. Then it is outside the polygon, or it is the
    // spare row of the tile.
    const Floats x = left + Floats{0, 1, 2, 3, 0, 1, 2, 3};
    const auto column = polygon.column(x);
    const Floats across = x - plane.x;
    for (int y = box.top; y <= box.bottom; y += 2, depths += 2 * row_, texels += 2 * row_) {
      const Floats pixel_y = static_cast<float>(y) + Floats{0, 0, 0, 0, 1, 1, 1, 1};
      const Floats down = pixel_y - plane.y;
      const std::array<Floats, 4> row = {
          plane.origin[0] + plane.per_y[0] * down, plane.origin[1] + plane.per_y[1] * down,
          plane.origin[2] + plane.per_y[2] * down, plane.origin[3] + plane.per_y[3] * down};
      keep(polygon.inside(column, polygon.row(pixel_y)), plane, row, across, depths, texels, row_);
    }
  } else {
    for (int y = box.top; y <= box.bottom; ++y, depths += row_, texels += row_) {
      const auto pixel_y = static_cast<float>(y);
      const auto edges = polygon.row(pixel_y);
      const Attributes row = plane.origin + plane.per_y * (pixel_y - plane.y);
      for (int x = 0; x <= box.right - box.left; x += kLanes) {
        const Floats pixel_x = ramp() + (left + static_cast<float>(x));
        keep(polygon.inside(polygon.column(pixel_x), edges), plane, row, pixel_x - plane.x, depths + x,
             texels + x, kLanes / 2);
      }
    }
  }
}

void Tile::draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c) {
  Box box;
  const Attributes at[] = {place(a), place(b), place(c)};
  if (!(area(a, b, c) > 0) ||
      !find_box(smaller(smaller(at[0], at[1]), at[2]), larger(larger(at[0], at[1]), at[2]), box)) {
    return;
  }
  AttributePlane plane;
  plane.origin = attributes(a);
  plane.x = a.x;
  plane.y = a.y;
  plane.nearest = std::max(std::max(a.w, b.w), c.w);
  plane.solve(b.x - a.x, b.y - a.y, attributes(b) - plane.origin, c.x - a.x, c.y - a.y,
              attributes(c) - plane.origin);
  fill(box, Polygon<3>({&a, &b, &c}), plane);
}

void Tile::draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, const ViewVertex& d) {
  Box box;
  const Attributes at[] = {place(a), place(b), place(c), place(d)};
  if (!find_box(smaller(smaller(at[0], at[1]), smaller(at[2], at[3])),
                larger(larger(at[0], at[1]), larger(at[2], at[3])), box)) {
    return;
  }
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
  fill(box, Polygon<4>({&a, &b, &c, &d}), plane);
}

namespace {

ClipVertex between(const ClipVertex& a, const ClipVertex& b, float t) {
  const auto mix = [t](float p, float q) { return p + (q - p) * t; };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z), mix(a.w, b.w), mix(a.u, b.u), mix(a.v, b.v)};
}

// Draws the part of a triangle in front of the near plane, z = near_m * w: up to two triangles.
void draw_clipped(const std::array<ClipVertex, 3>& corners, float near_m, Tile& tile) {
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
  for (int i = 2; i < count; ++i) tile.draw(kept[0], kept[i - 1], kept[i]);
}

}  // namespace

void draw_patch(const DepthMesh& mesh, const DepthMesh::Patch& patch, const PatchExtent& extent,
                const std::vector<ViewVertex>& vertices, const ProjectionMatrix& matrix, float near_m,
                Tile& tile) {
  const std::size_t first = patch.first_vertex;
  const auto triangle = [&](std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    if (extent.in_front) {
      tile.draw(vertices[first + a], vertices[first + b], vertices[first + c]);
    } else {
      draw_clipped({project(mesh, first + a, matrix), project(mesh, first + b, matrix),
                    project(mesh, first + c, matrix)},
                   near_m, tile);
    }
  };
  for (std::size_t q = patch.first_quad; q < patch.first_quad + patch.quads; ++q) {
    const auto& [a, b, c, d] = mesh.quads[q];
    if (extent.in_front) {
      tile.draw(vertices[first + a], vertices[first + b], vertices[first + c], vertices[first + d]);
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
