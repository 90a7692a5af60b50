#pragma once

// Makes a mesh from a camera's depth image, as merge_rules.h describes. The mesh is coarse where
// the image is planar. It is made once per frame and drawn from any pose. Thread: different objects
// may be used at the same time.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

struct DepthMesh {
  /// Each vector has one value per vertex and kSpare more. A vertex is the point (x, y, 1) / w in
  /// the camera's frame, in metres. (u, v) is its pixel.
  template <class T>
  using Vector = std::vector<T, UninitialisedAllocator<T>>;
  Vector<float> x, y, w, u, v;
  static constexpr std::size_t kSpare = 8;  ///< Allows vertices to be read in groups.
  std::size_t vertices() const { return x.size() - kSpare; }

  /// Corners are indices of vertices within the patch, clockwise as the camera sees them. A quad is
  /// split into two triangles from its second corner to its fourth.
  using Quad = std::array<std::uint16_t, 4>;
  using Triangle = std::array<std::uint16_t, 3>;
  Vector<Quad> quads;
  Vector<Triangle> triangles;

  /// The part of the mesh in a block of 16 pixels a side. Its elements are contiguous, and it
  /// shares no vertices with other patches.
  struct Patch {
    std::uint32_t first_vertex, vertices;
    std::uint32_t first_quad, quads;
    std::uint32_t first_triangle, triangles;
  };
  std::vector<Patch> patches;
};

/// The ray of each pixel, as (x, y) at z = 1 (common/frame/camera_model.h).
struct PixelRays {
  const std::vector<Eigen::Vector2f>& of_pixels;
  bool are_bent;  ///< Lens distortion makes x differ within a column, or y within a row.
};

/// Makes the mesh of an image after BlockStitching. `limits` are the arguments of connected().
/// Requires one ray per pixel of `inverse`, and blocks made from `inverse`.
void build_mesh(const InverseDepth& inverse, const MeshBlocks& blocks, const PixelRays& rays,
                const SurfaceLimits& limits, DepthMesh& mesh);

}  // namespace copresence::renderer
