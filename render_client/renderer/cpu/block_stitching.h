#pragma once

// Closes the cracks of a mesh whose neighbouring triangles differ in size (T-junctions). Thread:
// one thread at a time per object.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

/// Changes the inverse depth along the borders of planar blocks. Each border becomes a straight
/// line between its corners. All adjoining blocks share the same corners, so coarse and fine
/// triangles meet without cracks.
class BlockStitching {
 public:
  /// Requires that `planar` and `blocks` were made from `inverse`. Lens distortion bends the
  /// straight lines. If `bent_rays` is given, the rays of the border pixels are straightened.
  void draw(const PlanarBlocks& planar, const MeshBlocks& blocks, InverseDepth& inverse,
            std::vector<Eigen::Vector2f>* bent_rays = nullptr);

 private:
  struct Corner {
    float sum = 0, count = 0;
  };
  class Level;

  // Marks pixels on the border of a larger block. Smaller blocks do not change them.
  Image<std::uint8_t> drawn_;
  // The corners of some rows of blocks, by level. All values are 0 except while a level is drawn.
  std::array<Image<Corner>, kLevels> corners_;
};

}  // namespace copresence::renderer
