#include "render_client/renderer/depth_mesh.h"

#include <algorithm>
#include <cassert>
#include <span>

#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

// One patch while it is made. At most 17 x 17 vertices and a quad or a triangle per pixel.
class PatchBuilder {
 public:
  PatchBuilder(const InverseDepth& inverse, const std::vector<Eigen::Vector2f>& rays, float pixel_angle)
      : rays_(rays.data()),
        w_from_(inverse.w.data()),
        w_row_(inverse.w.width()),
        width_(inverse.width),
        last_x_(inverse.width - 1),
        last_y_(inverse.height - 1),
        pixel_angle_(pixel_angle) {}

  // The patch whose first pixel is (left, top).
  void build(int left, int top, std::span<const MeshBlocks::Part> parts) {
    left_ = left;
    top_ = top;
    numbers_.fill(kUnused);
    vertices_ = quads_ = triangles_ = 0;
    for (const MeshBlocks::Part& part : parts) add(part);
  }

  void append_to(DepthMesh& mesh) const {
    if (vertices_ == 0) return;
    mesh.patches.push_back({.first_vertex = static_cast<std::uint32_t>(mesh.x.size()),
                            .vertices = static_cast<std::uint32_t>(vertices_),
                            .first_quad = static_cast<std::uint32_t>(mesh.quads.size()),
                            .quads = static_cast<std::uint32_t>(quads_),
                            .first_triangle = static_cast<std::uint32_t>(mesh.triangles.size()),
                            .triangles = static_cast<std::uint32_t>(triangles_)});
    const auto append = [](auto& to, const auto& from, int count) {
      to.insert(to.end(), from.begin(), from.begin() + count);
    };
    append(mesh.x, x_, vertices_);
    append(mesh.y, y_, vertices_);
    append(mesh.w, w_, vertices_);
    append(mesh.u, u_, vertices_);
    append(mesh.v, v_, vertices_);
    append(mesh.quads, quad_, quads_);
    append(mesh.triangles, triangle_, triangles_);
  }

 private:
  static constexpr int kSide = 17;
  static constexpr std::uint16_t kUnused = 0xFFFF;

  void add(const MeshBlocks::Part& part) {
    const int size = kBlockSizes[part.level];
    const int x0 = size * part.block.i, y0 = size * part.block.j;
    const int x1 = std::min(x0 + size, last_x_), y1 = std::min(y0 + size, last_y_);
    if (part.is_flat) {
      add_quad(vertex(x0, y0), vertex(x1, y0), vertex(x1, y1), vertex(x0, y1));
      return;
    }
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) add_pixel(x, y);
    }
  }

  // The quad between four neighbouring pixels, as far as they are joined.
  void add_pixel(int x, int y) {
    const float* const upper = w_from_ + static_cast<std::ptrdiff_t>(y) * w_row_ + x;
    const float* const lower = upper + w_row_;
    const float a = upper[0], b = upper[1], c = lower[1], d = lower[0];
    const float nearest = std::max(std::max(a, b), std::max(c, d));
    const float farthest = std::min(std::min(a, b), std::min(c, d));
    if (nearest <= 0) return;
    if (farthest > 0 && joined(nearest, farthest, farthest, pixel_angle_)) {
      add_quad(vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1));
      return;
    }
    const auto holds = [&](float p, float q, float r) {
      return std::min(std::min(p, q), r) > 0 && joined(p, q, r, pixel_angle_);
    };
    const bool abd = holds(a, b, d), bcd = holds(b, c, d), abc = holds(a, b, c), acd = holds(a, c, d);
    if (abd && bcd) {
      add_quad(vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1));
    } else if (abc && acd) {
      add_quad(vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1), vertex(x, y));
    } else if (abd) {
      add_triangle(vertex(x, y), vertex(x + 1, y), vertex(x, y + 1));
    } else if (bcd) {
      add_triangle(vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1));
    } else if (abc) {
      add_triangle(vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1));
    } else if (acd) {
      add_triangle(vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1));
    }
  }

  void add_quad(std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
    quad_[quads_++] = {a, b, c, d};
  }
  void add_triangle(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    triangle_[triangles_++] = {a, b, c};
  }

  std::uint16_t vertex(int x, int y) {
    std::uint16_t& number = numbers_[(y - top_) * kSide + (x - left_)];
    if (number == kUnused) {
      number = static_cast<std::uint16_t>(vertices_);
      const Eigen::Vector2f& ray = rays_[static_cast<std::ptrdiff_t>(y) * width_ + x];
      x_[vertices_] = ray.x();
      y_[vertices_] = ray.y();
      w_[vertices_] = w_from_[static_cast<std::ptrdiff_t>(y) * w_row_ + x];
      u_[vertices_] = static_cast<float>(x);
      v_[vertices_] = static_cast<float>(y);
      ++vertices_;
    }
    return number;
  }

  // Without a check of every pixel: build_mesh() has checked the shapes.
  const Eigen::Vector2f* const rays_;
  const float* const w_from_;
  const int w_row_, width_, last_x_, last_y_;
  const float pixel_angle_;

  int left_ = 0, top_ = 0;
  int vertices_ = 0, quads_ = 0, triangles_ = 0;
  std::array<std::uint16_t, kSide * kSide> numbers_{};
  std::array<float, kSide * kSide> x_{}, y_{}, w_{}, u_{}, v_{};
  std::array<DepthMesh::Quad, 256> quad_{};
  std::array<DepthMesh::Triangle, 256> triangle_{};
};

}  // namespace

void build_mesh(const InverseDepth& inverse, const MeshBlocks& blocks,
                const std::vector<Eigen::Vector2f>& rays, float pixel_angle, DepthMesh& mesh) {
  assert(rays.size() == static_cast<std::size_t>(inverse.width) * inverse.height);
  assert(blocks.ends.size() == static_cast<std::size_t>(inverse.patches_x()) * inverse.patches_y());
  for (auto* numbers : {&mesh.x, &mesh.y, &mesh.w, &mesh.u, &mesh.v}) numbers->clear();
  mesh.quads.clear();
  mesh.triangles.clear();
  mesh.patches.clear();
  PatchBuilder patch(inverse, rays, pixel_angle);
  const std::span<const MeshBlocks::Part> parts = blocks.parts;
  std::size_t number = 0, begin = 0;
  for (int j = 0; j < inverse.patches_y(); ++j) {
    for (int i = 0; i < inverse.patches_x(); ++i) {
      const std::size_t end = blocks.ends[number++];
      patch.build(16 * i, 16 * j, parts.subspan(begin, end - begin));
      patch.append_to(mesh);
      begin = end;
    }
  }
  for (auto* numbers : {&mesh.x, &mesh.y, &mesh.w, &mesh.u, &mesh.v}) {
    numbers->resize(numbers->size() + DepthMesh::kSpare);
  }
}

}  // namespace copresence::renderer
