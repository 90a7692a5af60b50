#pragma once

// The blocks a mesh is made of, in the order in which it is made. Private to the CPU renderer. Thread: values; distinct
// ones are independent.

#include <array>
#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/flat_blocks.h"

namespace copresence::renderer {

/// Block (i, j) of a level of FlatBlocks.
struct MeshBlock {
  std::uint16_t i, j;
};

struct MeshBlocks {
  /// What of a patch (DepthMesh) is drawn: flat blocks that lie in no larger flat one, and those blocks of 2 that are
  /// not flat, whose pixels are joined one by one.
  struct Part {
    MeshBlock block;
    std::uint8_t level;
    bool is_flat;
  };
  std::vector<Part> parts;
  std::vector<std::uint32_t> ends;  ///< of the patches' parts, patch by patch and row by row

  struct Flat {
    MeshBlock block;
    Plane plane;
  };
  std::array<std::vector<Flat>, kLevels> flat;  ///< the flat ones again, by level
};

/// Flat blocks larger than `largest_block` pixels a side are divided. Requires 1, for a mesh of pixels alone, 4, 8 or 16.
/// Blocks without any depth are left out where they hold a block of 4. Keeps the memory of `blocks` where it can.
void list_blocks(const InverseDepth& inverse, const FlatBlocks& flat, int largest_block, MeshBlocks& blocks);

}  // namespace copresence::renderer
