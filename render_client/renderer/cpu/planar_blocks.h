#pragma once

// Finds the planar parts of a depth image. Planes of inverse depth are fitted to blocks from 2x2 to
// 16x16 pixels, which form a quadtree. A block includes the first pixels of its right and lower
// neighbours, since a mesh connects those as well. Thread: different objects are independent.

#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {

struct InverseDepth {
  int width = 0;  ///< Size of the depth image.
  int height = 0;
  /// Inverse depth in 1/m, 0 for a hole. The image is padded to whole 16x16 blocks and one pixel
  /// more. The padding repeats the last column and row.
  Image<float> w;

  /// Number of 16x16 blocks that are needed to contain all quads.
  int patches_x() const { return (width + 14) / 16; }
  int patches_y() const { return (height + 14) / 16; }
};

/// Computes the inverse depth of an image. Reuses the memory of `inverse`.
void invert_depth(const DepthImage& depth, double metres_per_unit, InverseDepth& inverse);

/// Inverse depth w at the middle of a block, 1/m, and its change per pixel. It is 0 if the block is
/// not planar, and negative if none of its pixels has depth.
struct Plane {
  float w = 0, dx = 0, dy = 0;
  bool is_planar() const { return w > 0; }
  bool is_empty() const { return w < 0; }
};

inline constexpr std::array<int, 4> kBlockSizes = {2, 4, 8, 16};
inline constexpr int kLevels = static_cast<int>(kBlockSizes.size());

struct PlanarBlocks {
  /// planes[level] belongs to blocks of kBlockSizes[level] pixels. Block (i, j) begins at pixel
  /// (size * i, size * j). The planes of 2x2 blocks are valid only where the 4x4 block around them
  /// is neither planar nor empty. A 2x2 block is never marked as empty.
  std::array<Image<Plane>, kLevels> planes;
};

/// Finds the planar blocks. All pixels of a planar block have depth and lie within kPlanarSteps of
/// its plane. The plane is not too steep for its pixels to be connected (merge_rules.h).
void find_planar_blocks(const InverseDepth& inverse, const SurfaceLimits& limits, PlanarBlocks& blocks);

/// The indices (i, j) of a block within a level of PlanarBlocks.
struct MeshBlock {
  std::uint16_t i, j;
};

/// The leaves of the quadtree of blocks, in the order in which a mesh contains them.
struct MeshBlocks {
  /// A leaf: a planar block that lies in no larger one, or a 2x2 block with connected pixels.
  struct Part {
    MeshBlock block;
    std::uint8_t level;
    bool is_planar;
  };
  std::vector<Part> parts;
  /// The end of each patch in `parts`, row by row. A patch is a 16x16 block.
  std::vector<std::uint32_t> ends;

  struct Planar {
    MeshBlock block;
    Plane plane;
  };
  std::array<std::vector<Planar>, kLevels> planar;  ///< The planar blocks of `parts` by level.
};

/// Lists the blocks of a mesh. Planar blocks larger than `largest_block` pixels a side are divided.
/// Requires 4, 8 or 16, or 1 for a mesh without planar blocks. Blocks without any depth are omitted
/// if they are 4x4 or larger. Reuses the memory of `blocks`.
void list_blocks(const InverseDepth& inverse, const PlanarBlocks& planar, int largest_block,
                 MeshBlocks& blocks);

}  // namespace copresence::renderer
