#pragma once

// Closes the cracks of a mesh whose neighbouring triangles differ in size (T-junctions).
//
// Thread: values; distinct ones are independent.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

/// Changes the depth image along the borders of planar blocks. Each border becomes a straight line
/// between corners on which all adjoining blocks agree, so that coarse and fine triangles meet
/// without cracks.
class BlockStitching {
 public:
  /// `planar` and `blocks` are those of `inverse`. A distorted lens sees a straight line bent. If
  /// `bent_rays` is given, the pixels of the borders get the rays of the straight lines.
  void draw(const PlanarBlocks& planar, const MeshBlocks& blocks, InverseDepth& inverse,
            std::vector<Eigen::Vector2f>* bent_rays = nullptr);

 private:
  struct Corner {
    float sum = 0, count = 0;
  };
  class Level;

  Image<std::uint8_t> drawn_;  // pixels on the border of a larger block: smaller blocks keep them
  // For some rows of blocks of each level. All zero except while a level is drawn.
  std::array<Image<Corner>, kLevels> corners_;
};

}  // namespace copresence::renderer
