#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/cpu/block_stitching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "common/frame/camera_model.h"
#include "render_client/renderer/merge_rules.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

const SurfaceLimits kLimits(kKinectV1Noise, 1 / 585.0F);
constexpr std::pair<int, int> kNobody{-1, -1};
using Corners = std::array<std::pair<int, int>, 4>;  // pixels; the last one of a triangle is (-1, -1)

// Rough ground with steps, holes and slopes. Some neighbours are connected, others are not.
DepthImage rough_depth(int width, int height, unsigned seed) {
  std::minstd_rand random(seed);
  std::uniform_int_distribution<int> kind(0, 9), noise(-40, 40);
  DepthImage depth(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int ground = (x / 7 + y / 5) % 3 == 0 ? 1500 : 2200;
      const int which = kind(random);
      depth(x, y) = static_cast<std::uint16_t>(which == 0 ? 0 : ground + noise(random) * (which < 4 ? 2 : 1));
    }
  }
  return depth;
}

InverseDepth inverse_of(const DepthImage& depth) {
  InverseDepth inverse;
  invert_depth(depth, 1e-3, inverse);
  return inverse;
}

struct Made {
  MeshBlocks blocks;
  DepthMesh mesh;
};

Made make(InverseDepth& inverse, int largest_block, const PixelRays& rays) {
  Made made;
  PlanarBlocks planar;
  find_planar_blocks(inverse, kLimits, planar);
  list_blocks(inverse, planar, largest_block, made.blocks);
  BlockStitching stitching;
  stitching.draw(planar, made.blocks, inverse);
  build_mesh(inverse, made.blocks, rays, kLimits, made.mesh);
  return made;
}

CameraModel model_of(int width, int height) {
  return {width, height, 585, 580, width / 2.0 + 0.3, height / 2.0 - 0.4, {}};
}

// The shape between the pixels from (x, y) on, by the Surface rule of merge_rules.h.
std::vector<Corners> drawn_between(const InverseDepth& inverse, int x, int y) {
  const std::pair<int, int> a{x, y}, b{x + 1, y}, c{x + 1, y + 1}, d{x, y + 1};
  const auto w = [&](std::pair<int, int> p) { return inverse.w(p.first, p.second); };
  const auto holds = [&](auto p, auto q, auto r) {
    return std::min({w(p), w(q), w(r)}) > 0 && connected(w(p), w(q), w(r), kLimits);
  };
  if (holds(a, b, d) && holds(b, c, d)) return {{a, b, c, d}};
  if (holds(a, b, c) && holds(a, c, d)) return {{b, c, d, a}};
  if (holds(a, b, d)) return {{a, b, d, kNobody}};
  if (holds(b, c, d)) return {{b, c, d, kNobody}};
  if (holds(a, b, c)) return {{a, b, c, kNobody}};
  if (holds(a, c, d)) return {{a, c, d, kNobody}};
  return {};
}

std::vector<Corners> drawn_by(const DepthMesh& mesh) {
  std::vector<Corners> all;
  for (const DepthMesh::Patch& patch : mesh.patches) {
    const auto pixel = [&](std::uint16_t vertex) {
      EXPECT_LT(vertex, patch.vertices);
      const std::size_t at = patch.first_vertex + vertex;
      return std::pair(static_cast<int>(mesh.u[at]), static_cast<int>(mesh.v[at]));
    };
    for (std::size_t q = patch.first_quad; q < patch.first_quad + patch.quads; ++q) {
      const auto& [a, b, c, d] = mesh.quads[q];
      all.push_back({pixel(a), pixel(b), pixel(c), pixel(d)});
    }
    for (std::size_t t = patch.first_triangle; t < patch.first_triangle + patch.triangles; ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      all.push_back({pixel(a), pixel(b), pixel(c), kNobody});
    }
  }
  return all;
}

TEST(DepthMesh, OfSinglePixelsDrawsWhatTheSurfaceRuleSays) {
  for (const auto& [width, height] :
       {std::pair(64, 48), std::pair(50, 34), std::pair(2, 2), std::pair(18, 2)}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      InverseDepth inverse = inverse_of(rough_depth(width, height, seed));
      const std::vector<Eigen::Vector2f> of_pixels = rays(model_of(width, height));
      std::vector<Corners> drawn = drawn_by(make(inverse, 1, {of_pixels, false}).mesh), expected;
      for (int y = 0; y + 1 < height; ++y) {
        for (int x = 0; x + 1 < width; ++x) {
          for (const Corners& corners : drawn_between(inverse, x, y)) expected.push_back(corners);
        }
      }
      std::sort(drawn.begin(), drawn.end());
      std::sort(expected.begin(), expected.end());
      EXPECT_EQ(drawn, expected) << width << " x " << height << ", seed " << seed;
    }
  }
}

TEST(DepthMesh, HasEachVertexOnceInAPatchWithItsRayAndDepth) {
  const int width = 90, height = 70;
  InverseDepth inverse = inverse_of(rough_depth(width, height, 7));
  const std::vector<Eigen::Vector2f> of_pixels = rays(model_of(width, height));
  const DepthMesh mesh = make(inverse, 16, {of_pixels, false}).mesh;
  ASSERT_FALSE(mesh.patches.empty());
  for (const DepthMesh::Patch& patch : mesh.patches) {
    std::vector<std::pair<int, int>> pixels;
    for (std::size_t i = patch.first_vertex; i < patch.first_vertex + patch.vertices; ++i) {
      const int u = static_cast<int>(mesh.u[i]), v = static_cast<int>(mesh.v[i]);
      pixels.emplace_back(u, v);
      const Eigen::Vector2f& ray = of_pixels[static_cast<std::size_t>(v * width + u)];
      EXPECT_EQ(mesh.x[i], ray.x());
      EXPECT_EQ(mesh.y[i], ray.y());
      EXPECT_EQ(mesh.w[i], inverse.w(u, v));
      EXPECT_GT(mesh.w[i], 0);
    }
    std::sort(pixels.begin(), pixels.end());
    EXPECT_EQ(std::adjacent_find(pixels.begin(), pixels.end()), pixels.end());
  }
}

TEST(DepthMesh, OfAStraightLensIsTheSameFromAllRaysAsFromTheFirstRowAndColumn) {
  const int width = 90, height = 70;
  InverseDepth inverse = inverse_of(rough_depth(width, height, 3));
  InverseDepth again = inverse;
  const std::vector<Eigen::Vector2f> of_pixels = rays(model_of(width, height));
  const DepthMesh from_some = make(inverse, 16, {of_pixels, false}).mesh;
  const DepthMesh from_all = make(again, 16, {of_pixels, true}).mesh;
  EXPECT_EQ(from_some.x, from_all.x);
  EXPECT_EQ(from_some.y, from_all.y);
  EXPECT_EQ(from_some.quads, from_all.quads);
}

// Planar blocks of all sizes side by side. Their common corners and the pixels on their borders lie
// in one line, in every strip of the image, so that the mesh has no cracks.
TEST(DepthMesh, HasNoCracksBetweenPlanarBlocksOfDifferentSizes) {
  const int width = 160, height = 120;
  DepthImage depth(width, height);
  std::minstd_rand random(5);
  std::uniform_int_distribution<int> noise(-8, 8);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double bulges = 200 * std::sin(x / 11.0) * std::sin(y / 9.0) * (x > 60 ? 1 : 0);
      depth(x, y) = static_cast<std::uint16_t>(2500 - bulges + noise(random));
    }
  }
  InverseDepth inverse = inverse_of(depth);
  const std::vector<Eigen::Vector2f> of_pixels = rays(model_of(width, height));
  const Made made = make(inverse, 16, {of_pixels, false});
  std::array<std::size_t, kLevels> planar{};
  for (int level = 0; level < kLevels; ++level) planar[level] = made.blocks.planar[level].size();
  ASSERT_GT(planar[1], 0U);
  ASSERT_GT(planar[3], 0U);
  // Every pixel on the border of a planar block that is a corner of a smaller block lies on the
  // line of the border.
  std::vector<bool> is_corner(static_cast<std::size_t>(width * height));
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(std::min(y, height - 1) * width + std::min(x, width - 1));
  };
  for (std::size_t i = 0; i < made.mesh.vertices(); ++i)
    is_corner[at(static_cast<int>(made.mesh.u[i]), static_cast<int>(made.mesh.v[i]))] = true;
  int checked = 0;
  for (int level = 1; level < kLevels; ++level) {
    const int size = kBlockSizes[level];
    for (const auto& [block, plane] : made.blocks.planar[level]) {
      const int x0 = size * block.i, y0 = size * block.j;
      if (x0 + size >= width || y0 + size >= height) continue;
      const auto check_line = [&](int x, int y, int dx, int dy) {
        const float first = inverse.w(x, y), last = inverse.w(x + size * dx, y + size * dy);
        for (int k = 1; k < size; ++k) {
          if (!is_corner[at(x + k * dx, y + k * dy)]) continue;
          ++checked;
          EXPECT_NEAR(inverse.w(x + k * dx, y + k * dy),
                      first + (last - first) * static_cast<float>(k) / static_cast<float>(size), 1e-6);
        }
      };
      check_line(x0, y0, 1, 0);
      check_line(x0, y0 + size, 1, 0);
      check_line(x0, y0, 0, 1);
      check_line(x0 + size, y0, 0, 1);
    }
  }
  EXPECT_GT(checked, 50);
}

}  // namespace
}  // namespace copresence::renderer
