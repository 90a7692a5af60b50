#include "render_client/renderer/cpu/planar_blocks.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr Plane kEmpty{.w = -1};

bool too_steep(const Plane& plane, const SurfaceLimits& limits) {
  return std::abs(plane.dx) + std::abs(plane.dy) > limits.gap + limits.slope * plane.w;
}

// Values for one row of 4x4 blocks, with an element for every column of the padded image. So the
// compiler can process eight columns at a time, although only every fourth plane belongs to a
// block.
struct Columns {
  // Sums over a column's five pixels. `moment` is weighted by the distance from the middle row.
  std::vector<float> sum, moment;
  std::vector<float> w, dx, dy;  // The plane fitted to the five columns that begin here.
  // The plane of the block that contains the column: w in the middle row, and its derivatives.
  std::vector<float> middle, across, down;
  std::vector<float> off;  // Greatest distance of this and the next column from that plane.

  explicit Columns(int columns)
      : sum(columns),
        moment(columns),
        w(columns),
        dx(columns),
        dy(columns),
        middle(columns),
        across(columns),
        down(columns),
        off(columns) {}
};

void fit_planes(const std::array<const float*, 5>& rows, int columns, Columns& c) {
  for (int x = 0; x < columns; ++x) {
    c.sum[x] = rows[0][x] + rows[1][x] + rows[2][x] + rows[3][x] + rows[4][x];
    c.moment[x] = 2 * (rows[4][x] - rows[0][x]) + (rows[3][x] - rows[1][x]);
  }
  const float* const sum = c.sum.data();
  const float* const moment = c.moment.data();
  for (int x = 0; x + 4 < columns; ++x) {
    // Least squares on a 5 x 5 grid. The squared offsets -2..2 have the sum 10 in each of 5 rows.
    c.w[x] = (sum[x] + sum[x + 1] + sum[x + 2] + sum[x + 3] + sum[x + 4]) * (1.0F / 25);
    c.dx[x] = (2 * (sum[x + 4] - sum[x]) + (sum[x + 3] - sum[x + 1])) * (1.0F / 50);
    c.dy[x] = (moment[x] + moment[x + 1] + moment[x + 2] + moment[x + 3] + moment[x + 4]) * (1.0F / 50);
  }
}

void measure_distances(const std::array<const float*, 5>& rows, int blocks, Columns& c) {
  for (int i = 0; i < blocks; ++i) {
    const int begin = 4 * i;
    const float w = c.w[begin], dx = c.dx[begin], dy = c.dy[begin];
    for (int k = 0; k < 4; ++k) {
      c.middle[begin + k] = w + dx * static_cast<float>(k - 2);
      c.across[begin + k] = dx;
      c.down[begin + k] = dy;
    }
  }
  for (int x = 0; x < 4 * blocks; ++x) {
    float off = 0;
    for (int r = 0; r < 5; ++r) {
      const float here = c.middle[x] + c.down[x] * static_cast<float>(r - 2);
      off = std::max(off, std::abs(rows[r][x] - here));
      off = std::max(off, std::abs(rows[r][x + 1] - (here + c.across[x])));
    }
    c.off[x] = off;
  }
}

void find_blocks_of_4(const InverseDepth& inverse, const SurfaceLimits& limits, Image<Plane>& planes) {
  const int columns = inverse.w.width();
  Columns c(columns);
  for (int j = 0; j < planes.height(); ++j) {
    std::array<const float*, 5> rows{};
    for (int r = 0; r < 5; ++r) rows[r] = inverse.w.row(4 * j + r).data();
    fit_planes(rows, columns, c);
    measure_distances(rows, planes.width(), c);
    const std::span<Plane> row = planes.row(j);
    for (int i = 0; i < planes.width(); ++i) {
      const int x = 4 * i;
      if (c.w[x] == 0) {
        row[i] = kEmpty;
        continue;
      }
      // A hole beside pixels with depth is far from any plane, so the block is not planar.
      const Plane plane{c.w[x], c.dx[x], c.dy[x]};
      const float off = std::max(std::max(c.off[x], c.off[x + 1]), std::max(c.off[x + 2], c.off[x + 3]));
      row[i] = off <= limits.planar && !too_steep(plane, limits) ? plane : Plane{};
    }
  }
}

// Fits planes to the four 2x2 blocks from pixel (x, y) on. Each fit uses 3 x 3 pixels.
void fit_blocks_of_2(const InverseDepth& inverse, int x, int y, const SurfaceLimits& limits,
                     Image<Plane>& planes) {
  std::array<std::array<Four, 3>, 3> pixels;  // Indexed by row and column within each block.
  for (int r = 0; r < 3; ++r) {
    const auto columns = [&](int row, int column) {
      Four four;
      std::memcpy(&four, inverse.w.row(row).data() + column, sizeof four);
      return four;
    };
    const Four upper = columns(y + r, x), lower = columns(y + r + 2, x);
    const Four upper_right = columns(y + r, x + 1), lower_right = columns(y + r + 2, x + 1);
    pixels[r][0] = __builtin_shufflevector(upper, lower, 0, 2, 4, 6);
    pixels[r][1] = __builtin_shufflevector(upper, lower, 1, 3, 5, 7);
    pixels[r][2] = __builtin_shufflevector(upper_right, lower_right, 1, 3, 5, 7);
  }
  Four w{}, dx{}, dy{};
  for (const auto& [left, middle, right] : pixels) {
    w += left + middle + right;
    dx += right - left;
  }
  for (int c = 0; c < 3; ++c) dy += pixels[2][c] - pixels[0][c];
  w *= 1.0F / 9;
  dx *= 1.0F / 6;
  dy *= 1.0F / 6;
  const auto size_of = [](const Four& v) { return v < 0.0F ? -v : v; };
  Four off{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const Four here = w + dx * static_cast<float>(c - 1) + dy * static_cast<float>(r - 1);
      off = larger(off, size_of(pixels[r][c] - here));
    }
  }
  const Four steepest = limits.gap + limits.slope * w;
  const FourInts is_planar = (off <= limits.planar) & (size_of(dx) + size_of(dy) <= steepest);
  for (int i = 0; i < 4; ++i)
    planes.row(y / 2 + i / 2)[x / 2 + i % 2] = is_planar[i] ? Plane{w[i], dx[i], dy[i]} : Plane{};
}

void find_blocks_of_2(const InverseDepth& inverse, const SurfaceLimits& limits,
                      const Image<Plane>& blocks_of_4, Image<Plane>& planes) {
  for (int j = 0; j < blocks_of_4.height(); ++j) {
    const std::span<const Plane> row = blocks_of_4.row(j);
    for (int i = 0; i < blocks_of_4.width(); ++i) {
      const bool is_planar_or_empty = row[i].w != 0;
      if (!is_planar_or_empty) fit_blocks_of_2(inverse, 4 * i, 4 * j, limits, planes);
    }
  }
}

// Returns the common plane of the four quarters of a block, each `size` pixels a side. The result
// is not planar if a quarter deviates from it by more than `tolerance`.
Plane join(const Plane& a, const Plane& b, const Plane& c, const Plane& d, float size, float tolerance) {
  if (!a.is_planar() || !b.is_planar() || !c.is_planar() || !d.is_planar()) {
    return a.is_empty() && b.is_empty() && c.is_empty() && d.is_empty() ? kEmpty : Plane{};
  }
  const Plane whole{(a.w + b.w + c.w + d.w) * 0.25F, ((b.w - a.w) + (d.w - c.w)) * (0.5F / size),
                    ((c.w - a.w) + (d.w - b.w)) * (0.5F / size)};
  const float half = 0.5F * size;
  // The greatest distance between a quarter's plane and the whole plane is at a corner.
  const auto off = [&](const Plane& quarter, float sign_x, float sign_y) {
    const float middle = whole.w + half * (sign_x * whole.dx + sign_y * whole.dy);
    return std::abs(quarter.w - middle) +
           half * (std::abs(quarter.dx - whole.dx) + std::abs(quarter.dy - whole.dy));
  };
  const float worst =
      std::max(std::max(off(a, -1, -1), off(b, 1, -1)), std::max(off(c, -1, 1), off(d, 1, 1)));
  return worst <= tolerance ? whole : Plane{};
}

void invert_row(const std::uint16_t* from, int width, float per_unit, float* to) {
  for (int x = 0; x < width; ++x) {
    const auto value = static_cast<float>(from[x]);
    // For a hole, `value` and `there` are 0, so no branch is needed.
    const float there = std::min(value, 1.0F);
    to[x] = per_unit * there / std::max(value, 1.0F);
  }
}

// Descends the quadtree of each patch. The level is a template parameter to make it a constant.
class BlockLister {
 public:
  BlockLister(const InverseDepth& inverse, const PlanarBlocks& planar, int largest_block, MeshBlocks& blocks)
      : last_x_(inverse.width - 1), last_y_(inverse.height - 1), planar_(planar), blocks_(blocks) {
    for (int level = 0; level < kLevels; ++level) {
      is_used_[level] = kBlockSizes[level] <= largest_block;
      assert(planar.planes[level].width() == 16 / kBlockSizes[level] * inverse.patches_x());
      assert(planar.planes[level].height() == 16 / kBlockSizes[level] * inverse.patches_y());
    }
  }

  template <int kLevel>
  void list(int i, int j) {
    if (kBlockSizes[kLevel] * i >= last_x_ || kBlockSizes[kLevel] * j >= last_y_) return;
    const Image<Plane>& planes = planar_.planes[kLevel];
    const Plane& plane = planes.data()[static_cast<std::ptrdiff_t>(j) * planes.width() + i];
    if (plane.is_empty()) return;
    const MeshBlock block{static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j)};
    if (is_used_[kLevel] && plane.is_planar()) {
      blocks_.parts.push_back({block, kLevel, true});
      blocks_.planar[kLevel].push_back({block, plane});
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
  const PlanarBlocks& planar_;
  MeshBlocks& blocks_;
};

}  // namespace

void invert_depth(const DepthImage& depth, double metres_per_unit, InverseDepth& inverse) {
  inverse.width = depth.width();
  inverse.height = depth.height();
  inverse.w.resize(16 * inverse.patches_x() + 1, 16 * inverse.patches_y() + 1);
  const float per_unit = static_cast<float>(1.0 / metres_per_unit);
  for (int y = 0; y < inverse.w.height(); ++y) {
    const auto to = inverse.w.row(y);
    if (y < depth.height()) {
      invert_row(depth.row(y).data(), depth.width(), per_unit, to.data());
      std::fill(to.begin() + depth.width(), to.end(), to[depth.width() - 1]);
    } else {
      std::copy_n(inverse.w.row(y - 1).begin(), to.size(), to.begin());
    }
  }
}

void find_planar_blocks(const InverseDepth& inverse, const SurfaceLimits& limits, PlanarBlocks& blocks) {
  blocks.planes[1].resize(4 * inverse.patches_x(), 4 * inverse.patches_y());
  find_blocks_of_4(inverse, limits, blocks.planes[1]);
  // The 2x2 blocks in a planar or empty 4x4 block are skipped. They keep values of an older frame.
  Image<Plane>& blocks_of_2 = blocks.planes[0];
  if (blocks_of_2.width() != 8 * inverse.patches_x() || blocks_of_2.height() != 8 * inverse.patches_y())
    blocks_of_2 = Image<Plane>(8 * inverse.patches_x(), 8 * inverse.patches_y());
  find_blocks_of_2(inverse, limits, blocks.planes[1], blocks_of_2);
  for (int level = 2; level < kLevels; ++level) {
    const Image<Plane>& quarters = blocks.planes[level - 1];
    Image<Plane>& wholes = blocks.planes[level];
    wholes.resize(quarters.width() / 2, quarters.height() / 2);
    for (int j = 0; j < wholes.height(); ++j) {
      const std::span<const Plane> upper = quarters.row(2 * j), lower = quarters.row(2 * j + 1);
      const std::span<Plane> row = wholes.row(j);
      for (int i = 0; i < wholes.width(); ++i) {
        row[i] = join(upper[2 * i], upper[2 * i + 1], lower[2 * i], lower[2 * i + 1],
                      static_cast<float>(kBlockSizes[level - 1]), limits.curvature);
      }
    }
  }
}

void list_blocks(const InverseDepth& inverse, const PlanarBlocks& planar, int largest_block,
                 MeshBlocks& blocks) {
  assert(largest_block == 1 || largest_block >= 4);
  blocks.parts.clear();
  blocks.ends.clear();
  for (auto& level : blocks.planar) level.clear();
  BlockLister lister(inverse, planar, largest_block, blocks);
  for (int j = 0; j < inverse.patches_y(); ++j) {
    for (int i = 0; i < inverse.patches_x(); ++i) {
      lister.list<kLevels - 1>(i, j);
      blocks.ends.push_back(static_cast<std::uint32_t>(blocks.parts.size()));
    }
  }
}

}  // namespace copresence::renderer
