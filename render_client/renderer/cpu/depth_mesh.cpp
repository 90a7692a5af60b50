#include "render_client/renderer/cpu/depth_mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <span>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr FourInts kBits{1, 2, 4, 8};

// Returns one value for each of the four quads of a 2x2 block. The upper left quad is first.
Four pairs(const float* upper, const float* lower) {
  using Two = float __attribute__((vector_size(8)));
  Two first, second;
  std::memcpy(&first, upper, sizeof first);
  std::memcpy(&second, lower, sizeof second);
  return __builtin_shufflevector(first, second, 0, 1, 2, 3);
}

// The shape that is drawn between four neighbouring pixels a, b, c and d, clockwise from the upper
// left pixel. A triangle repeats one of its corners.
struct Shape {
  std::array<std::uint8_t, 4> corners;
  std::uint8_t quads, triangles;
};

// The shapes, indexed by four bits. Bits 0 to 3 are set if the pixels abd, bcd, abc and acd are
// connected. The diagonal from b to d is preferred (merge_rules.h).
constexpr std::array<Shape, 16> kShapes = [] {
  constexpr Shape kNone{{0, 0, 0, 0}, 0, 0}, kQuad{{0, 1, 2, 3}, 1, 0}, kOther{{1, 2, 3, 0}, 1, 0};
  std::array<Shape, 16> shapes{};
  for (int connected = 0; connected < 16; ++connected) {
    Shape& shape = shapes[connected];
    if ((connected & 3) == 3) {
      shape = kQuad;
    } else if ((connected & 12) == 12) {
      shape = kOther;
    } else if (connected & 1) {
      shape = {{0, 1, 3, 0}, 0, 1};
    } else if (connected & 2) {
      shape = {{1, 2, 3, 1}, 0, 1};
    } else if (connected & 4) {
      shape = {{0, 1, 2, 0}, 0, 1};
    } else {
      shape = connected & 8 ? Shape{{0, 2, 3, 0}, 0, 1} : kNone;
    }
  }
  return shapes;
}();

// Appends one patch after the other to a mesh. The mesh must have room for 17 x 17 vertices and one
// quad or triangle per pixel. Most of this code avoids branches, since they would be unpredictable.
class PatchBuilder {
 public:
  PatchBuilder(const InverseDepth& inverse, const PixelRays& rays, const SurfaceLimits& limits,
               DepthMesh& mesh)
      : rays_(rays.of_pixels.data()->data()),
        column_step_(rays.are_bent ? 1 : 0),
        row_step_(rays.are_bent ? inverse.width : 0),
        w_from_(inverse.w.data()),
        w_row_(inverse.w.width()),
        width_(inverse.width),
        last_x_(inverse.width - 1),
        last_y_(inverse.height - 1),
        gap_(limits.gap),
        slope_(limits.slope),
        mesh_(mesh) {}

  void build(int left, int top, std::span<const MeshBlocks::Part> parts) {
    left_ = left;
    top_ = top;
    numbers_.fill(kUnused);
    const std::uint32_t first_quad = quads_, first_triangle = triangles_;
    vertices_ = 0;
    quad_ = mesh_.quads.data() + quads_;
    triangle_ = mesh_.triangles.data() + triangles_;
    for (const MeshBlocks::Part& part : parts) add(part);
    if (vertices_ == 0) return;
    quads_ = static_cast<std::uint32_t>(quad_ - mesh_.quads.data());
    triangles_ = static_cast<std::uint32_t>(triangle_ - mesh_.triangles.data());
    mesh_.patches.push_back({.first_vertex = first_vertex_,
                             .vertices = vertices_,
                             .first_quad = first_quad,
                             .quads = quads_ - first_quad,
                             .first_triangle = first_triangle,
                             .triangles = triangles_ - first_triangle});
    place_vertices();
    first_vertex_ += vertices_;
  }

  void finish() {
    for (auto* numbers : {&mesh_.x, &mesh_.y, &mesh_.w, &mesh_.u, &mesh_.v}) {
      numbers->resize(first_vertex_ + DepthMesh::kSpare);
      std::fill(numbers->begin() + first_vertex_, numbers->end(), 0.0F);
    }
    mesh_.quads.resize(quads_);
    mesh_.triangles.resize(triangles_);
  }

 private:
  static constexpr int kSide = 17;
  // The two bytes of kUnused differ, because g++ uses a slow instruction to fill memory with equal
  // bytes.
  static constexpr std::uint16_t kUnused = 0xFFFE;
  // The position of a vertex within the patch is y << kRowBit | x.
  static constexpr int kRowBit = 5;

  void add(const MeshBlocks::Part& part) {
    const int size = kBlockSizes[part.level];
    const int x0 = size * part.block.i, y0 = size * part.block.j;
    if (part.is_planar) {
      const int x1 = std::min(x0 + size, last_x_), y1 = std::min(y0 + size, last_y_);
      *quad_++ = {vertex(x0, y0), vertex(x1, y0), vertex(x1, y1), vertex(x0, y1)};
    } else {
      add_pixels(x0, y0);
    }
  }

  // Adds the quads of a 2x2 block whose pixels are connected.
  void add_pixels(int x, int y) {
    const float* const row = w_from_ + static_cast<std::ptrdiff_t>(y) * w_row_ + x;
    const float *const row1 = row + w_row_, *const row2 = row1 + w_row_;
    const Four a = pairs(row, row1), b = pairs(row + 1, row1 + 1), c = pairs(row1 + 1, row2 + 1),
               d = pairs(row1, row2);
    const auto are_connected = [this](const Four& p, const Four& q, const Four& r) {
      const Four nearest = larger(larger(p, q), r), farthest = smaller(smaller(p, q), r);
      return (farthest > 0.0F) & (nearest - farthest <= gap_ + slope_ * farthest);
    };
    const FourInts abd = are_connected(a, b, d), bcd = are_connected(b, c, d), abc = are_connected(a, b, c),
                   acd = are_connected(a, c, d);
    const FourInts connected = (abd & kBits[0]) | (bcd & kBits[1]) | (abc & kBits[2]) | (acd & kBits[3]);
    add_shape(x, y, connected[0]);
    if (x + 1 < last_x_) add_shape(x + 1, y, connected[1]);
    if (y + 1 >= last_y_) return;
    add_shape(x, y + 1, connected[2]);
    if (x + 1 < last_x_) add_shape(x + 1, y + 1, connected[3]);
  }

  void add_shape(int x, int y, int connected) {
    if (connected == 0) return;
    const Shape& shape = kShapes[connected];
    const int at = place(x, y);
    const auto corner = [&](int i) {
      constexpr std::array<int, 4> kPlaces{0, 1, (1 << kRowBit) + 1, 1 << kRowBit};
      return vertex_at(at + kPlaces[shape.corners[i]]);
    };
    const std::uint16_t p = corner(0), q = corner(1), r = corner(2), s = corner(3);
    *quad_ = {p, q, r, s};
    *triangle_ = {p, q, r};
    quad_ += shape.quads;
    triangle_ += shape.triangles;
  }

  int place(int x, int y) const { return (y - top_) << kRowBit | (x - left_); }
  std::uint16_t vertex(int x, int y) { return vertex_at(place(x, y)); }

  // Returns the number of the vertex at this position. A new vertex gets the next number.
  std::uint16_t vertex_at(int place) {
    const auto next = static_cast<std::uint16_t>(vertices_);
    std::uint16_t& number = numbers_[place];
    const bool is_new = number == kUnused;
    number = is_new ? next : number;
    places_[next] = static_cast<std::uint16_t>(place);
    vertices_ += is_new;
    return number;
  }

  void place_vertices() {
    float *const x = mesh_.x.data() + first_vertex_, *const y = mesh_.y.data() + first_vertex_,
                 *const w = mesh_.w.data() + first_vertex_, *const u = mesh_.u.data() + first_vertex_,
                 *const v = mesh_.v.data() + first_vertex_;
    // The last group may write into the memory of the next patch, or into spare memory.
    for (std::uint32_t i = 0; i < vertices_; i += kLanes) {
      std::array<std::uint16_t, kLanes> place;
      std::copy_n(places_.begin() + i, kLanes, place.begin());
      Ints at;
      for (int lane = 0; lane < kLanes; ++lane) at[lane] = place[lane];
      const Ints column = smaller(left_ + (at & ((1 << kRowBit) - 1)), all(last_x_));
      const Ints row = smaller(top_ + (at >> kRowBit), all(last_y_));
      store(x + i, gather(rays_, 2 * (row * row_step_ + column)));
      store(y + i, gather(rays_, 2 * (row * width_ + column * column_step_) + 1));
      store(w + i, gather(w_from_, row * w_row_ + column));
      store(u + i, as_floats(column));
      store(v + i, as_floats(row));
    }
  }

  static Floats gather(const float* from, const Ints& index) {
    Floats result{};
    for (int lane = 0; lane < kLanes; ++lane) result[lane] = from[index[lane]];
    return result;
  }

  // The pointers are used without bounds checks, since build_mesh() has checked the sizes.
  const float* const rays_;  // The ray x, y of each pixel.
  // Both steps are 0 if x is equal within each column and y within each row. Then the first row and
  // column are enough, and stay in the cache.
  const int column_step_, row_step_;
  const float* const w_from_;
  const int w_row_, width_, last_x_, last_y_;
  const float gap_, slope_;
  DepthMesh& mesh_;
  // Numbers of elements in all earlier patches.
  std::uint32_t first_vertex_ = 0, quads_ = 0, triangles_ = 0;

  int left_ = 0, top_ = 0;
  std::uint32_t vertices_ = 0;
  DepthMesh::Quad* quad_ = nullptr;
  DepthMesh::Triangle* triangle_ = nullptr;
  std::array<std::uint16_t, kSide << kRowBit> numbers_{};  // Vertex numbers by position.
  // Positions by vertex number, with room for a whole last group.
  std::array<std::uint16_t, kSide * kSide + kLanes> places_{};
};

}  // namespace

void build_mesh(const InverseDepth& inverse, const MeshBlocks& blocks, const PixelRays& rays,
                const SurfaceLimits& limits, DepthMesh& mesh) {
  assert(rays.of_pixels.size() == static_cast<std::size_t>(inverse.width) * inverse.height);
  assert(blocks.ends.size() == static_cast<std::size_t>(inverse.patches_x()) * inverse.patches_y());
  // The largest mesh has 9 vertices and 4 quads or triangles per 2x2 block. A planar block has 4
  // vertices and one quad. Shapes without a quad or triangle write to one spare element.
  const std::size_t parts = blocks.parts.size();
  for (auto* numbers : {&mesh.x, &mesh.y, &mesh.w, &mesh.u, &mesh.v})
    numbers->resize(9 * parts + DepthMesh::kSpare);
  mesh.quads.resize(4 * parts + 1);
  mesh.triangles.resize(4 * parts + 1);
  mesh.patches.clear();
  PatchBuilder patch(inverse, rays, limits, mesh);
  std::size_t number = 0, begin = 0;
  for (int j = 0; j < inverse.patches_y(); ++j) {
    for (int i = 0; i < inverse.patches_x(); ++i) {
      const std::size_t end = blocks.ends[number++];
      patch.build(16 * i, 16 * j, std::span(blocks.parts).subspan(begin, end - begin));
      begin = end;
    }
  }
  patch.finish();
}

}  // namespace copresence::renderer
