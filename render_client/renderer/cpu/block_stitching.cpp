#include "render_client/renderer/cpu/block_stitching.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace copresence::renderer {
namespace {
constexpr int kStripRows = 16;  // The height of a patch. MeshBlocks is ordered by patches.
}

// Draws the borders of one level's blocks. For speed, the code uses pointers without bounds checks.
class BlockStitching::Level {
 public:
  Level(const PlanarBlocks& planar, int level, const MeshBlocks& blocks, InverseDepth& inverse,
        Image<std::uint8_t>& drawn, Image<Corner>& corners, std::vector<Eigen::Vector2f>* bent_rays)
      : planes_(planar.planes[level]),
        parents_(level == 0 ? &planar.planes[1] : nullptr),
        blocks_(blocks.planar[level]),
        size_(kBlockSizes[level]),
        last_x_(inverse.width - 1),
        last_y_(inverse.height - 1),
        image_row_(inverse.width),
        row_(inverse.w.width()),
        w_(inverse.w.data()),
        drawn_(drawn.data()),
        bent_rays_(bent_rays ? bent_rays->data() : nullptr),
        corner_row_(planes_.width() + 1),
        corner_rows_(4 * kStripRows / size_) {
    if (corners.width() != corner_row_) corners = Image<Corner>(corner_row_, corner_rows_);
    corners_ = corners.data();
  }

  // Draws one strip. Call it for every strip, from the first on.
  void draw(int strip) {
    // The blocks of the next strip contribute to the corners at the bottom of this one.
    for (; added_ < blocks_.size() && lies_in(strip + 1, blocks_[added_].block); ++added_)
      add_corners(blocks_[added_]);
    for (; finished_ < blocks_.size() && lies_in(strip, blocks_[finished_].block); ++finished_) {
      const MeshBlock& block = blocks_[finished_].block;
      for (int dj = 0; dj < 2; ++dj) {
        for (int di = 0; di < 2; ++di) draw_corner(block.i + di, block.j + dj);
      }
      if (size_ == 2 && bent_rays_ == nullptr) {
        draw_middles(block);
      } else {
        draw_lines(block);
      }
    }
  }

 private:
  // Returns whether the block lies in this strip or an earlier strip.
  bool lies_in(int strip, const MeshBlock& block) const { return block.j * size_ < (strip + 1) * kStripRows; }

  // A block that reaches beyond the image ends at the image's last pixel.
  int x_of(int i) const { return std::min(i * size_, last_x_); }
  int y_of(int j) const { return std::min(j * size_, last_y_); }

  // Only two strips and the row below are in use. Their memory is reused while it is in the cache.
  Corner& corner_at(int i, int j) { return corners_[(j & (corner_rows_ - 1)) * corner_row_ + i]; }

  void add_corners(const MeshBlocks::Planar& planar) {
    const auto& [block, plane] = planar;
    const float middle = 0.5F * static_cast<float>(size_);
    for (int dj = 0; dj < 2; ++dj) {
      const float dy = static_cast<float>(y_of(block.j + dj) - block.j * size_) - middle;
      for (int di = 0; di < 2; ++di) {
        const float dx = static_cast<float>(x_of(block.i + di) - block.i * size_) - middle;
        Corner& corner = corner_at(block.i + di, block.j + dj);
        corner.sum += plane.w + dx * plane.dx + dy * plane.dy;
        corner.count += 1;
      }
    }
  }

  void draw_corner(int i, int j) {
    Corner& corner = corner_at(i, j);
    draw_pixel(y_of(j) * row_ + x_of(i), corner.sum / corner.count, corner.count > 0);
    corner = {};
  }

  // Writes w if `is_due` and if the pixel is not drawn yet. A branch would be unpredictable.
  void draw_pixel(int at, float w, bool is_due) {
    const std::uint32_t draws = -static_cast<std::uint32_t>(is_due & (drawn_[at] == 0));
    w_[at] = std::bit_cast<float>((std::bit_cast<std::uint32_t>(w) & draws) |
                                  (std::bit_cast<std::uint32_t>(w_[at]) & ~draws));
    drawn_[at] |= static_cast<std::uint8_t>(is_due);
  }

  // Draws the four borders of a 2x2 block. Testing if a border is needed would take longer.
  void draw_middles(const MeshBlock& block) {
    const int x0 = x_of(block.i), x1 = x_of(block.i + 1), y0 = y_of(block.j), y1 = y_of(block.j + 1);
    const int at = y0 * row_ + x0, below = y1 * row_ + x0;
    if (x1 - x0 == 2) {
      draw_middle(at, 1);
      draw_middle(below, 1);
    }
    if (y1 - y0 == 2) {
      draw_middle(at, row_);
      draw_middle(at + (x1 - x0), row_);
    }
  }

  void draw_middle(int begin, int step) {
    const float first = w_[begin];
    draw_pixel(begin + step, first + 0.5F * (w_[begin + 2 * step] - first), true);
  }

  // Returns whether a block of the same size is planar or lies in a planar block. A border between
  // two such blocks needs no pixels, since no smaller block has a corner on it.
  bool is_planar(int i, int j) const {
    if (i < 0 || j < 0 || i >= planes_.width() || j >= planes_.height()) return true;
    if (parents_) {
      const Plane& parent = parents_->data()[static_cast<std::ptrdiff_t>(j / 2) * parents_->width() + i / 2];
      if (parent.w != 0) return parent.is_planar();
    }
    return planes_.data()[static_cast<std::ptrdiff_t>(j) * planes_.width() + i].is_planar();
  }

  void draw_lines(const MeshBlock& block) {
    const int i = block.i, j = block.j;
    const int x0 = x_of(i), x1 = x_of(i + 1), y0 = y_of(j), y1 = y_of(j + 1);
    if (!is_planar(i, j - 1)) draw_line(x0, y0, 1, 0, x1 - x0);
    if (!is_planar(i, j + 1)) draw_line(x0, y1, 1, 0, x1 - x0);
    if (!is_planar(i - 1, j)) draw_line(x0, y0, 0, 1, y1 - y0);
    if (!is_planar(i + 1, j)) draw_line(x1, y0, 0, 1, y1 - y0);
  }

  // Draws the pixels between two corners. If the first pixel is drawn already, all of them are,
  // since two blocks share a whole border or none of it.
  void draw_line(int x, int y, int step_x, int step_y, int length) {
    const int begin = y * row_ + x, step = step_y * row_ + step_x;
    if (length < 2 || drawn_[begin + step]) return;
    const float first = w_[begin], slope = (w_[begin + step * length] - first) / static_cast<float>(length);
    for (int k = 1; k < length; ++k) {
      w_[begin + step * k] = first + slope * static_cast<float>(k);
      drawn_[begin + step * k] = 1;
    }
    if (bent_rays_ == nullptr) return;
    Eigen::Vector2f* const rays = bent_rays_ + static_cast<std::ptrdiff_t>(y) * image_row_ + x;
    const std::ptrdiff_t ray_step = static_cast<std::ptrdiff_t>(step_y) * image_row_ + step_x;
    const Eigen::Vector2f change = (rays[ray_step * length] - rays[0]) / static_cast<float>(length);
    for (int k = 1; k < length; ++k) rays[ray_step * k] = rays[0] + change * static_cast<float>(k);
  }

  const Image<Plane>& planes_;
  const Image<Plane>* parents_;  // Null except for 2x2 blocks.
  const std::vector<MeshBlocks::Planar>& blocks_;
  std::size_t added_ = 0, finished_ = 0;
  int size_, last_x_, last_y_, image_row_, row_;
  float* w_;
  std::uint8_t* drawn_;
  Eigen::Vector2f* bent_rays_;
  int corner_row_, corner_rows_;
  Corner* corners_ = nullptr;
};

void BlockStitching::draw(const PlanarBlocks& planar, const MeshBlocks& blocks, InverseDepth& inverse,
                          std::vector<Eigen::Vector2f>* bent_rays) {
  drawn_.resize(inverse.w.width(), inverse.w.height());
  std::fill(drawn_.pixels().begin(), drawn_.pixels().end(), std::uint8_t{0});
  const auto level = [&](int number) {
    return Level(planar, number, blocks, inverse, drawn_, corners_[number], bent_rays);
  };
  std::array<Level, kLevels> levels{level(0), level(1), level(2), level(3)};
  // Large blocks are drawn first, because the border of a small block must follow that of a larger
  // one. Each level is one strip behind the next larger level, so all work on pixels in the cache.
  for (int strip = 0; strip < inverse.patches_y() + kLevels - 1; ++strip) {
    for (int number = kLevels - 1; number >= 0; --number) {
      const int behind = kLevels - 1 - number;
      if (strip >= behind) levels[number].draw(strip - behind);
    }
  }
}

}  // namespace copresence::renderer
