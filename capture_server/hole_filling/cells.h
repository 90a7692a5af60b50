#pragma once

// Depth in cells of 4x4 pixels: the surfaces in each cell, and their slopes. Wide holes are filled
// from cells: there are sixteen times fewer of them than pixels, and they are four times less
// noisy. Thread: one thread at a time per object.

#include <array>
#include <vector>

#include "common/frame/image.h"

namespace copresence::hole_filling {

class Cells {
 public:
  static constexpr int kMargin = 2;  ///< empty cells around the image, so that neighbours need no check
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
                                                         {-1, 1}}};  // opposite directions are neighbours

  Cells(int width_px, int height_px);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Index of a cell in the arrays below. Requires -kMargin <= column < columns() + kMargin, and
  /// the same of rows.
  int at(int column, int row) const { return (row + kMargin) * stride_ + column + kMargin; }
  int offset(Direction direction) const { return direction.dy * stride_ + direction.dx; }

  /// Replaces the content by a new picture. Requires images of this size.
  void see(const DepthImage& depth, const Image<std::uint8_t>& fillable, float steps_times_units);

  /// Depth of a pixel in disparity steps; 0 if it has none or is outside the image. Rows are
  /// pixel_stride() apart. Requires a pixel at most kMarginPx outside the cells.
  const float* steps(int x, int y) const { return &steps_[pixel_at(x, y)]; }
  int pixel_stride() const { return pixel_stride_; }
  static constexpr int kMarginPx = 4;

  // Per cell. A cell whose depths differ by more than kOneSurface holds two surfaces, split at the
  // middle of its range.
  std::vector<float> far,
      near;  ///< steps of the surfaces at the cell's middle; meaningless without such a surface
  std::vector<std::uint8_t> far_count,
      near_count;                       ///< measured pixels on them; near_count is 0 if there is one surface
  std::vector<float> slope_x, slope_y;  ///< steps per pixel; 0 if unknown
  std::vector<std::uint8_t> wanted;     ///< whether the cell has fillable holes

  /// Per direction and cell: distance in cells to the next one with depth, 0 if there is none
  /// within kReachCells.
  std::array<std::vector<std::uint8_t>, 8> reach;

 private:
  struct Strip {
    std::vector<float> sum, nearest, farthest;
    std::vector<std::uint8_t> count, row_sum, wanted;
  };
  struct CellRow {  // sums over a cell's pixels, made from those of Strip
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
  std::array<std::vector<std::uint8_t>, 2> lines_;  // a row of cells with empty margins

  std::vector<float> middle_x_, middle_y_;  // centroid of a cell's measured pixels, pixels from its middle
  std::vector<float> smooth_;               // a cell's depth if it holds one surface, else kNoSurface
  std::vector<std::uint8_t> has_depth_;
};

}  // namespace copresence::hole_filling
