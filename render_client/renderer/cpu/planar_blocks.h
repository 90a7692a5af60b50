#pragma once

// Finds the planar parts of a depth image: planes of inverse depth, fitted to blocks of 2 to 16
// pixels a side. The blocks form a quadtree. A block includes the first pixels of its right and
// lower neighbours, since a mesh connects those as well.
//
// Thread: values; distinct ones are independent.

#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {

/// Inverse depth of every pixel, 1/m; 0 without depth. The last column and row are repeated to fill
/// whole blocks of 16 and one pixel more.
struct InverseDepth {
  int width = 0;  ///< of the depth image
  int height = 0;
  Image<float> w;

  /// Number of blocks of 16 pixels that contain all quads.
  int patches_x() const { return (width + 14) / 16; }
  int patches_y() const { return (height + 14) / 16; }
};

/// `metres_per_unit` of the depth values. Keeps the memory of `inverse` where it can.
void invert_depth(const DepthImage& depth, double metres_per_unit, InverseDepth& inverse);

/// w at the middle of a block, and its change per pixel. w = 0 if the block is not planar, w < 0 if
/// it has no depth.
struct Plane {
  float w = 0, dx = 0, dy = 0;
  bool is_planar() const { return w > 0; }
  bool is_empty() const { return w < 0; }
};

inline constexpr std::array<int, 4> kBlockSizes = {2, 4, 8, 16};
inline constexpr int kLevels = static_cast<int>(kBlockSizes.size());

struct PlanarBlocks {
  /// By level, for blocks of kBlockSizes[level]. Block (i, j) begins at pixel (size * i, size * j).
  /// Blocks of 2 have a plane only where the block of 4 around them is neither planar nor empty.
  /// Elsewhere their planes are undefined, and they are never empty.
  std::array<Image<Plane>, kLevels> planes;
};

/// A block is planar if all its pixels have depth and lie within kPlanarSteps of its plane, and if
/// the plane is not too steep for its pixels to be connected (merge_rules.h).
void find_planar_blocks(const InverseDepth& inverse, const SurfaceLimits& limits, PlanarBlocks& blocks);

/// Block (i, j) of a level of PlanarBlocks.
struct MeshBlock {
  std::uint16_t i, j;
};

/// The leaves of the quadtree of blocks, in the order in which a mesh is made of them.
struct MeshBlocks {
  /// A planar block that lies in no larger planar one, or a block of 2 whose pixels are connected
  /// one by one.
  struct Part {
    MeshBlock block;
    std::uint8_t level;
    bool is_planar;
  };
  std::vector<Part> parts;
  std::vector<std::uint32_t> ends;  ///< end of each patch in `parts`, row by row; a patch is a block of 16

  struct Planar {
    MeshBlock block;
    Plane plane;
  };
  std::array<std::vector<Planar>, kLevels> planar;  ///< the planar parts again, by level
};

/// Divides planar blocks larger than `largest_block` pixels a side. Requires 4, 8 or 16; or 1, for
/// a mesh of pixels alone. Leaves out blocks of 4 and larger without any depth. Keeps the memory of
/// `blocks` where it can.
void list_blocks(const InverseDepth& inverse, const PlanarBlocks& planar, int largest_block,
                 MeshBlocks& blocks);

}  // namespace copresence::renderer
