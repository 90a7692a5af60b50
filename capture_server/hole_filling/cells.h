#pragma once

// A depth image divided into cells of 4x4 pixels. Each cell has its surfaces and their slopes. Wide
// holes are filled from cells: they are sixteen times fewer and four times less noisy than pixels.
// Thread: one thread at a time per object.

#include <array>
#include <vector>

#include "common/frame/image.h"

namespace copresence::hole_filling {

class Cells {
 public:
  /// Width of the border of empty cells, so that neighbours need no check.
  static constexpr int kMargin = 2;
  struct Direction {
    int dx, dy;
  };
  static constexpr std::array<Direction, 8> kDirections{{{1, 0},
                                                         {-1, 0},
                                                         {0, 1},
                                                         {0, -1},
                                                         {1, 1},
                                                         {-1, -1},
                                                         {1, -1},
                                                         {-1, 1}}};  // Opposite directions follow each other.

  Cells(int width_px, int height_px);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Index of a cell in the arrays below. Requires -kMargin <= column < columns() + kMargin, and
  /// row likewise.
  int at(int column, int row) const { return (row + kMargin) * stride_ + column + kMargin; }
  int offset(Direction direction) const { return direction.dy * stride_ + direction.dx; }

  /// Replaces the content by that of a new picture. Requires images of the constructor's size.
  void see(const DepthImage& depth, const Image<std::uint8_t>& fillable, float steps_times_units);

  /// Points to the depth of pixel (x, y) in disparity steps. A depth is 0 in a hole or outside the
  /// image. Rows are pixel_stride() apart. Requires a pixel at most kMarginPx outside the cells.
  const float* steps(int x, int y) const { return &steps_[pixel_at(x, y)]; }
  int pixel_stride() const { return pixel_stride_; }
  static constexpr int kMarginPx = 4;

  // The following arrays have one element per cell. A cell whose depths differ by more than
  // kOneSurface holds two surfaces, split at the middle of its depth range.
  /// Depths of the two surfaces at the cell's middle, in steps. Meaningless without that surface.
  std::vector<float> far, near;
  /// Number of measured pixels on each surface. `near_count` is 0 if the cell holds one surface.
  std::vector<std::uint8_t> far_count, near_count;
  std::vector<float> slope_x, slope_y;  ///< Slope in steps per pixel; 0 if unknown.
  std::vector<std::uint8_t> wanted;     ///< The value is 1 if the cell has fillable holes, else 0.

  /// Per direction and cell: distance to the next cell with depth, in cells; 0 beyond kReachCells.
  std::array<std::vector<std::uint8_t>, 8> reach;

 private:
  struct Strip {
    std::vector<float> sum, nearest, farthest;
    std::vector<std::uint8_t> count, row_sum, wanted;
  };
  struct CellRow {  // Sums over each cell's pixels, made from the sums of Strip.
    std::vector<float> sum, spread;
    std::vector<std::uint8_t> column_sum, row_sum;
  };
  static constexpr int kLineMargin = 4;
  std::size_t pixel_at(int x, int y) const {
    return static_cast<std::size_t>(y + kMarginPx) * pixel_stride_ + static_cast<std::size_t>(x + kMarginPx);
  }
  void add_row(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> fillable, int y,
               float steps_times_units);
  void add_up_cells(std::size_t first);
  void close_strip(int row);
  void split(int cell, int column, int row);
  void find_slopes();
  void move_to_middles();
  void find_reach();
  void find_reach_along(const std::uint8_t* has, int dx, std::uint8_t* out);

  int columns_, rows_, stride_, pixel_stride_;
  std::vector<float> steps_;
  Strip strip_;
  CellRow cells_;
  std::array<std::vector<std::uint8_t>, 2> lines_;  // A row of cells with empty margins.

  // Centroid of each cell's measured pixels, in pixels from the cell's middle.
  std::vector<float> middle_x_, middle_y_;
  std::vector<float> smooth_;  // Depth of each cell that holds one surface, else kNoSurface.
  std::vector<std::uint8_t> has_depth_;
};

}  // namespace copresence::hole_filling
