#include <algorithm>
#include <cassert>

#include "render_client/renderer/depth_mesh.h"

namespace copresence::renderer {

// The outlines of one level's blocks. Unchecked addresses: these are the pixels that every frame has most of.
class BlockOutlines::Level {
 public:
  Level(const FlatBlocks& flat, int level, InverseDepth& inverse, Image<std::uint8_t>& drawn,
        Image<Corner>& corners, std::vector<Eigen::Vector2f>* bent_rays)
      : planes_(flat.planes[level]),
        parents_(level == 0 ? &flat.planes[1] : nullptr),
        size_(kBlockSizes[level]),
        last_x_(inverse.width - 1),
        last_y_(inverse.height - 1),
        image_row_(inverse.width),
        row_(inverse.w.width()),
        w_(inverse.w.data()),
        drawn_(drawn.data()),
        bent_rays_(bent_rays ? bent_rays->data() : nullptr),
        corner_row_(planes_.width() + 1) {
    // They are zero whenever nothing is being drawn.
    if (corners.width() != corner_row_ || corners.height() != planes_.height() + 1)
      corners = Image<Corner>(corner_row_, planes_.height() + 1);
    corners_ = corners.data();
  }

  void draw(const std::vector<MeshBlock>& blocks) {
    for (const MeshBlock& block : blocks) add_corners(block);
    for (const MeshBlock& block : blocks) {
      for (int dj = 0; dj < 2; ++dj) {
        for (int di = 0; di < 2; ++di) draw_corner(block.i + di, block.j + dj);
      }
    }
    for (const MeshBlock& block : blocks) draw_lines(block);
  }

 private:
  // The last blocks may reach beyond the image; their outline is its border.
  int x_of(int i) const { return std::min(i * size_, last_x_); }
  int y_of(int j) const { return std::min(j * size_, last_y_); }

  void add_corners(const MeshBlock& block) {
    const Plane& plane = planes_.data()[static_cast<std::ptrdiff_t>(block.j) * planes_.width() + block.i];
    const float middle = 0.5F * static_cast<float>(size_);
    for (int dj = 0; dj < 2; ++dj) {
      const float dy = static_cast<float>(y_of(block.j + dj) - block.j * size_) - middle;
      for (int di = 0; di < 2; ++di) {
        const float dx = static_cast<float>(x_of(block.i + di) - block.i * size_) - middle;
        Corner& corner = corners_[(block.j + dj) * corner_row_ + block.i + di];
        corner.sum += plane.w + dx * plane.dx + dy * plane.dy;
        ++corner.count;
      }
    }
  }

  void draw_corner(int i, int j) {
    Corner& corner = corners_[j * corner_row_ + i];
    const int at = y_of(j) * row_ + x_of(i);
    if (corner.count > 0 && !drawn_[at]) {
      w_[at] = corner.sum / static_cast<float>(corner.count);
      drawn_[at] = 1;
    }
    corner = {};
  }

  // Whether a block of the same size is flat, or lies in a flat one. A line between two of these needs no pixels: no
  // smaller block has a corner on it.
  bool is_flat(int i, int j) const {
    if (i < 0 || j < 0 || i >= planes_.width() || j >= planes_.height()) return true;  // beyond the image
    if (parents_) {
      const Plane& parent = parents_->data()[static_cast<std::ptrdiff_t>(j / 2) * parents_->width() + i / 2];
      if (parent.w != 0) return parent.is_flat();
    }
    return planes_.data()[static_cast<std::ptrdiff_t>(j) * planes_.width() + i].is_flat();
  }

  void draw_lines(const MeshBlock& block) {
    const int i = block.i, j = block.j;
    const int x0 = x_of(i), x1 = x_of(i + 1), y0 = y_of(j), y1 = y_of(j + 1);
    if (!is_flat(i, j - 1)) draw_line(x0, y0, 1, 0, x1 - x0);
    if (!is_flat(i, j + 1)) draw_line(x0, y1, 1, 0, x1 - x0);
    if (!is_flat(i - 1, j)) draw_line(x0, y0, 0, 1, y1 - y0);
    if (!is_flat(i + 1, j)) draw_line(x1, y0, 0, 1, y1 - y0);
  }

  // The pixels between two corners. Where the first is drawn all are: a line is shared whole or not at all.
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
  const Image<Plane>* parents_;  // of blocks of 2, which have a plane only where the parent's is not flat
  int size_, last_x_, last_y_, image_row_, row_;
  float* w_;
  std::uint8_t* drawn_;
  Eigen::Vector2f* bent_rays_;
  int corner_row_;
  Corner* corners_ = nullptr;
};

void BlockOutlines::draw(const FlatBlocks& flat, const MeshBlocks& blocks, InverseDepth& inverse,
                         std::vector<Eigen::Vector2f>* bent_rays) {
  drawn_.resize(inverse.w.width(), inverse.w.height());
  std::fill(drawn_.pixels().begin(), drawn_.pixels().end(), std::uint8_t{0});
  // Large before small: a small block on a large one's outline has to follow it.
  for (int level = kLevels - 1; level >= 0; --level) {
    Level(flat, level, inverse, drawn_, corners_[level], bent_rays).draw(blocks.flat[level]);
  }
}

}  // namespace copresence::renderer
