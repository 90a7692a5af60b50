#include "render_client/renderer/cpu/mesh_blocks.h"

#include <cassert>

namespace copresence::renderer {
namespace {

// Goes down from one patch after the other. Every level is a function of its own, so that nothing asks for it.
class BlockLister {
 public:
  BlockLister(const InverseDepth& inverse, const FlatBlocks& flat, int largest_block, MeshBlocks& blocks)
      : last_x_(inverse.width - 1), last_y_(inverse.height - 1), flat_(flat), blocks_(blocks) {
    for (int level = 0; level < kLevels; ++level) {
      is_used_[level] = kBlockSizes[level] <= largest_block;
      assert(flat.planes[level].width() == 16 / kBlockSizes[level] * inverse.patches_x());
      assert(flat.planes[level].height() == 16 / kBlockSizes[level] * inverse.patches_y());
    }
  }

  template <int kLevel>
  void list(int i, int j) {
    if (kBlockSizes[kLevel] * i >= last_x_ || kBlockSizes[kLevel] * j >= last_y_) return;
    const Image<Plane>& planes = flat_.planes[kLevel];
    const Plane& plane = planes.data()[static_cast<std::ptrdiff_t>(j) * planes.width() + i];
    if (plane.is_empty()) return;
    const MeshBlock block{static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j)};
    if (is_used_[kLevel] && plane.is_flat()) {
      blocks_.parts.push_back({block, kLevel, true});
      blocks_.flat[kLevel].push_back({block, plane});
    } else if constexpr (kLevel > 0) {
      list<kLevel - 1>(2 * i, 2 * j);
      list<kLevel - 1>(2 * i + 1, 2 * j);
      list<kLevel - 1>(2 * i, 2 * j + 1);
      list<kLevel - 1>(2 * i + 1, 2 * j + 1);
    } else {
      blocks_.parts.push_back({block, kLevel, false});
    }
  }

 private:
  int last_x_, last_y_;
  std::array<bool, kLevels> is_used_{};
  const FlatBlocks& flat_;
  MeshBlocks& blocks_;
};

}  // namespace

void list_blocks(const InverseDepth& inverse, const FlatBlocks& flat, int largest_block, MeshBlocks& blocks) {
  assert(largest_block == 1 || largest_block >= 4);
  blocks.parts.clear();
  blocks.ends.clear();
  for (auto& level : blocks.flat) level.clear();
  BlockLister lister(inverse, flat, largest_block, blocks);
  for (int j = 0; j < inverse.patches_y(); ++j) {
    for (int i = 0; i < inverse.patches_x(); ++i) {
      lister.list<kLevels - 1>(i, j);
      blocks.ends.push_back(static_cast<std::uint32_t>(blocks.parts.size()));
    }
  }
}

}  // namespace copresence::renderer
