#pragma once

// A camera's depth image as a surface: the mesh that merge_rules.h describes, coarse where the image is flat.
// Made once per frame, drawn from any eye. Private to the CPU renderer. Thread: values; distinct ones are
// independent.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/cpu/flat_blocks.h"
#include "render_client/renderer/cpu/mesh_blocks.h"

namespace copresence::renderer {

struct DepthMesh {
  /// One number per vertex, and kSpare more. The point is (x, y, 1) / w, metres in the camera's frame; u, v
  /// are its pixel.
  template <class T>
  using Vector = std::vector<T, UninitialisedAllocator<T>>;
  Vector<float> x, y, w, u, v;
  static constexpr std::size_t kSpare = 8;  ///< so that vertices can be read in groups
  std::size_t vertices() const { return x.size() - kSpare; }

  /// Corners by their number within the patch, clockwise as the camera sees them. A quad is two triangles,
  /// split from its second corner to its fourth.
  using Quad = std::array<std::uint16_t, 4>;
  using Triangle = std::array<std::uint16_t, 3>;
  Vector<Quad> quads;
  Vector<Triangle> triangles;

  /// What lies in a block of 16 pixels a side; contiguous, and sharing no vertices with other patches.
  struct Patch {
    std::uint32_t first_vertex, vertices;
    std::uint32_t first_quad, quads;
    std::uint32_t first_triangle, triangles;
  };
  std::vector<Patch> patches;
};

/// Draws the outlines of flat blocks into the depth image: straight lines between corners on which all
/// adjoining blocks agree, so that coarse and fine triangles meet without cracks.
class BlockOutlines {
 public:
  /// `flat` and `blocks` are those of `inverse`.
  /// A distorted lens sees a straight line bent: where `bent_rays` is given, the pixels of the outlines get
  /// the straight lines' rays.
  void draw(const FlatBlocks& flat, const MeshBlocks& blocks, InverseDepth& inverse,
            std::vector<Eigen::Vector2f>* bent_rays = nullptr);

 private:
  struct Corner {
    float sum = 0, count = 0;
  };
  class Level;

  Image<std::uint8_t> drawn_;  // pixels on a larger block's outline: smaller blocks take them as they are
  std::array<Image<Corner>, kLevels>
      corners_;  // of some rows of the level's blocks; zero but while it is drawn
};

/// (x, y) at z = 1 by pixel (common/frame/camera_model.h).
struct PixelRays {
  const std::vector<Eigen::Vector2f>& of_pixels;
  bool are_bent;  ///< by the lens: x is not the same all down a column, or y not along a row
};

/// The mesh of an image whose outlines are drawn. `limits` as in joined(). Requires as many rays as pixels of
/// `inverse`, and its `blocks`.
void build_mesh(const InverseDepth& inverse, const MeshBlocks& blocks, const PixelRays& rays,
                const SurfaceLimits& limits, DepthMesh& mesh);

}  // namespace copresence::renderer
