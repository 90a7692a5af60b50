#pragma once

// A camera's depth image as a mesh, as merge_rules.h describes it. It is coarse where the image is
// planar. It is made once per frame and drawn from any pose.
//
// Thread: values; distinct ones are independent.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

struct DepthMesh {
  /// One value per vertex, and kSpare more. The point is (x, y, 1) / w, metres in the camera's
  /// frame. u, v are its pixel.
  template <class T>
  using Vector = std::vector<T, UninitialisedAllocator<T>>;
  Vector<float> x, y, w, u, v;
  static constexpr std::size_t kSpare = 8;  ///< allows vertices to be read in groups
  std::size_t vertices() const { return x.size() - kSpare; }

  /// Corners are numbers of vertices within the patch, clockwise as the camera sees them. A quad is
  /// two triangles, split from its second corner to its fourth.
  using Quad = std::array<std::uint16_t, 4>;
  using Triangle = std::array<std::uint16_t, 3>;
  Vector<Quad> quads;
  Vector<Triangle> triangles;

  /// The part of the mesh in a block of 16 pixels a side. It is contiguous, and shares no vertices
  /// with other patches.
  struct Patch {
    std::uint32_t first_vertex, vertices;
    std::uint32_t first_quad, quads;
    std::uint32_t first_triangle, triangles;
  };
  std::vector<Patch> patches;
};

/// (x, y) at z = 1 for each pixel (common/frame/camera_model.h).
struct PixelRays {
  const std::vector<Eigen::Vector2f>& of_pixels;
  bool are_bent;  ///< by lens distortion: x differs within a column, or y within a row
};

/// Makes the mesh of an image whose blocks are stitched. `limits` as in connected(). Requires as
/// many rays as `inverse` has pixels, and the blocks of `inverse`.
void build_mesh(const InverseDepth& inverse, const MeshBlocks& blocks, const PixelRays& rays,
                const SurfaceLimits& limits, DepthMesh& mesh);

}  // namespace copresence::renderer
