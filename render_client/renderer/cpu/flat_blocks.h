#pragma once

// Where a depth image is flat: planes of inverse depth, fitted to its blocks of 2 to 16 pixels a side. A
// block spans its pixels and the first ones of its right and lower neighbours, since a mesh joins those as
// well. Private to the renderers. Thread: values; distinct ones are independent.

#include <array>

#include "common/frame/image.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {

/// Inverse depth of every pixel, 1/m, 0 where there is none; the last column and row are repeated until whole
/// blocks of 16 and one pixel more are there.
struct InverseDepth {
  int width = 0;  ///< of the depth image
  int height = 0;
  Image<float> w;

  int patches_x() const { return (width + 14) / 16; }  ///< blocks of 16 pixels that hold all quads
  int patches_y() const { return (height + 14) / 16; }
};

/// `metres_per_unit` of the depth values. Keeps its memory where it can.
void invert_depth(const DepthImage& depth, double metres_per_unit, InverseDepth& inverse);

/// w at a block's middle, and its change per pixel. Not flat: w = 0; without any depth: w < 0.
struct Plane {
  float w = 0, dx = 0, dy = 0;
  bool is_flat() const { return w > 0; }
  bool is_empty() const { return w < 0; }
};

inline constexpr std::array<int, 4> kBlockSizes = {2, 4, 8, 16};
inline constexpr int kLevels = static_cast<int>(kBlockSizes.size());

struct FlatBlocks {
  /// By level, blocks of kBlockSizes[level]; block (i, j) begins at pixel (size i, size j). Blocks of 2 have
  /// a plane only where the block of 4 that holds them is neither flat nor empty; elsewhere it is undefined, and they
  /// are never empty.
  std::array<Image<Plane>, kLevels> planes;
};

/// A block is flat when every one of its pixels has depth, lies within kPlanarSteps of its plane, and the
/// plane is not so steep that the pixels would not be joined (merge_rules.h).
void find_flat_blocks(const InverseDepth& inverse, const SurfaceLimits& limits, FlatBlocks& blocks);

}  // namespace copresence::renderer
