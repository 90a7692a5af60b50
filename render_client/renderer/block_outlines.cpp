#include <algorithm>
#include <cassert>

#include "render_client/renderer/depth_mesh.h"

namespace copresence::renderer {

void BlockOutlines::draw(const FlatBlocks& blocks, int largest_block, InverseDepth& inverse,
                         std::vector<Eigen::Vector2f>* bent_rays) {
  assert(largest_block == 1 || largest_block >= 4);
  drawn_.resize(inverse.w.width(), inverse.w.height());
  std::fill(drawn_.pixels().begin(), drawn_.pixels().end(), std::uint8_t{0});
  for (auto& level : listed_) level.clear();
  if (largest_block == 1) return;
  for (int j = 0; j < inverse.patches_y(); ++j) {
    for (int i = 0; i < inverse.patches_x(); ++i) list(blocks, kLevels - 1, {i, j}, largest_block, inverse);
  }
  // Large before small: a small block on a large one's outline has to follow it.
  for (int level = kLevels - 1; level >= 0; --level)
    draw_level(blocks.planes[level], level, inverse, bent_rays);
}

void BlockOutlines::list(const FlatBlocks& blocks, int level, Block block, int largest_block,
                         const InverseDepth& inverse) {
  const int size = kBlockSizes[level];
  if (block.i * size >= inverse.width - 1 || block.j * size >= inverse.height - 1) return;
  if (size <= largest_block && blocks.planes[level](block.i, block.j).is_flat()) {
    listed_[level].push_back(block);
  } else if (level > 0) {
    for (int dj = 0; dj < 2; ++dj) {
      for (int di = 0; di < 2; ++di) {
        list(blocks, level - 1, {2 * block.i + di, 2 * block.j + dj}, largest_block, inverse);
      }
    }
  }
}

void BlockOutlines::draw_level(const Image<Plane>& planes, int level, InverseDepth& inverse,
                               std::vector<Eigen::Vector2f>* bent_rays) {
  const int size = kBlockSizes[level];
  const float middle = 0.5F * static_cast<float>(size);
  // The last blocks may reach beyond the image; their outline is its border.
  const int last_x = inverse.width - 1, last_y = inverse.height - 1;
  const auto x_of = [&](int i) { return std::min(i * size, last_x); };
  const auto y_of = [&](int j) { return std::min(j * size, last_y); };
  Image<Corner>& corners = corners_[level];
  corners.resize(planes.width() + 1, planes.height() + 1);
  const auto for_each_corner = [&](const Block& block, auto&& visit) {
    for (int dj = 0; dj < 2; ++dj) {
      for (int di = 0; di < 2; ++di) {
        visit(corners(block.i + di, block.j + dj), x_of(block.i + di), y_of(block.j + dj));
      }
    }
  };

  for (const Block& block : listed_[level]) {
    const Plane& plane = planes(block.i, block.j);
    for_each_corner(block, [&](Corner& corner, int x, int y) {
      corner.sum += plane.w + (static_cast<float>(x - block.i * size) - middle) * plane.dx +
                    (static_cast<float>(y - block.j * size) - middle) * plane.dy;
      ++corner.count;
    });
  }
  for (const Block& block : listed_[level]) {
    for_each_corner(block, [&](Corner& corner, int x, int y) {
      if (corner.count > 0 && !drawn_(x, y)) {
        inverse.w(x, y) = corner.sum / static_cast<float>(corner.count);
        drawn_(x, y) = 1;
      }
      corner = {};
    });
  }

  float* const w = inverse.w.data();
  std::uint8_t* const drawn = drawn_.data();
  const int row = inverse.w.width();
  // The pixels between two corners. Where the first is drawn all are: a line is shared whole or not at all.
  const auto line = [&](int x, int y, int step_x, int step_y, int length) {
    const int begin = y * row + x, step = step_y * row + step_x;
    if (length < 2 || drawn[begin + step]) return;
    const float slope = (w[begin + step * length] - w[begin]) / static_cast<float>(length);
    for (int k = 1; k < length; ++k) {
      w[begin + step * k] = w[begin] + slope * static_cast<float>(k);
      drawn[begin + step * k] = 1;
    }
    if (bent_rays == nullptr) return;
    Eigen::Vector2f* const rays = bent_rays->data() + static_cast<std::ptrdiff_t>(y) * inverse.width + x;
    const std::ptrdiff_t ray_step = static_cast<std::ptrdiff_t>(step_y) * inverse.width + step_x;
    const Eigen::Vector2f change = (rays[ray_step * length] - rays[0]) / static_cast<float>(length);
    for (int k = 1; k < length; ++k) rays[ray_step * k] = rays[0] + change * static_cast<float>(k);
  };
  for (const Block& block : listed_[level]) {
    const int x0 = x_of(block.i), x1 = x_of(block.i + 1);
    const int y0 = y_of(block.j), y1 = y_of(block.j + 1);
    line(x0, y0, 1, 0, x1 - x0);
    line(x0, y1, 1, 0, x1 - x0);
    line(x0, y0, 0, 1, y1 - y0);
    line(x1, y0, 0, 1, y1 - y0);
  }
}

}  // namespace copresence::renderer
