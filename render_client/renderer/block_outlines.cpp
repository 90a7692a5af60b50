#include <algorithm>

#include "render_client/renderer/depth_mesh.h"

namespace copresence::renderer {

void BlockOutlines::draw(const FlatBlocks& blocks, int largest_block, InverseDepth& inverse) {
  drawn_.resize(inverse.w.width(), inverse.w.height());
  std::fill(drawn_.pixels().begin(), drawn_.pixels().end(), std::uint8_t{0});
  // Large before small: a small block on a large one's outline has to follow it.
  for (int level = 2; level >= 0; --level) {
    if (kBlockSizes[level] <= largest_block) draw_level(blocks, level, largest_block, inverse);
  }
}

void BlockOutlines::draw_level(const FlatBlocks& blocks, int level, int largest_block,
                               InverseDepth& inverse) {
  const Image<Plane>& planes = blocks.planes[level];
  const int size = kBlockSizes[level];
  const int last_x = inverse.width - 1;
  const int last_y = inverse.height - 1;
  const int corners_x = planes.width() + 1;
  const auto corner = [&](int i, int j) -> Corner& {
    return corners_[static_cast<std::size_t>(j) * corners_x + i];
  };
  const auto for_each_block = [&](auto&& visit) {
    for (int j = 0; j < planes.height(); ++j) {
      for (int i = 0; i < planes.width(); ++i) {
        if (blocks.is_drawn(level, i, j, largest_block) && i * size < last_x && j * size < last_y)
          visit(i, j);
      }
    }
  };

  corners_.assign(static_cast<std::size_t>(corners_x) * (planes.height() + 1), Corner{});
  for_each_block([&](int i, int j) {
    const Plane& plane = planes(i, j);
    for (int dj = 0; dj < 2; ++dj) {
      for (int di = 0; di < 2; ++di) {
        // The last blocks may reach beyond the image; their outline is its border.
        const auto dx = static_cast<float>(std::min((i + di) * size, last_x) - i * size - size / 2);
        const auto dy = static_cast<float>(std::min((j + dj) * size, last_y) - j * size - size / 2);
        Corner& c = corner(i + di, j + dj);
        c.sum += plane.w + dx * plane.dx + dy * plane.dy;
        ++c.count;
      }
    }
  });
  for (int j = 0; j <= planes.height(); ++j) {
    for (int i = 0; i < corners_x; ++i) {
      const int x = std::min(i * size, last_x);
      const int y = std::min(j * size, last_y);
      const Corner& c = corner(i, j);
      if (c.count == 0 || drawn_(x, y)) continue;
      inverse.w(x, y) = c.sum / static_cast<float>(c.count);
      drawn_(x, y) = 1;
    }
  }
  const auto line = [&](int x, int y, int step_x, int step_y, int length) {
    const float begin = inverse.w(x, y);
    const float end = inverse.w(x + step_x * length, y + step_y * length);
    const float slope = (end - begin) / static_cast<float>(length);
    for (int k = 1; k < length; ++k) {
      const int at_x = x + step_x * k, at_y = y + step_y * k;
      if (drawn_(at_x, at_y)) continue;
      inverse.w(at_x, at_y) = begin + slope * static_cast<float>(k);
      drawn_(at_x, at_y) = 1;
    }
  };
  for_each_block([&](int i, int j) {
    const int x0 = i * size, x1 = std::min(x0 + size, last_x);
    const int y0 = j * size, y1 = std::min(y0 + size, last_y);
    line(x0, y0, 1, 0, x1 - x0);
    line(x0, y1, 1, 0, x1 - x0);
    line(x0, y0, 0, 1, y1 - y0);
    line(x1, y0, 0, 1, y1 - y0);
  });
}

}  // namespace copresence::renderer
