#include "capture_server/hole_filling/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "capture_server/hole_filling/filling_rules.h"

namespace copresence::hole_filling {
namespace {

// Depth here and there, a quarter of it on a second surface.
DepthImage scattered(int width, int height, unsigned seed, double share) {
  std::minstd_rand random(seed);
  std::bernoulli_distribution has_depth(share), is_near(0.25);
  std::uniform_int_distribution<int> noise(-10, 10);
  DepthImage depth(width, height);
  for (auto& z : depth.pixels())
    z = static_cast<std::uint16_t>(has_depth(random) ? (is_near(random) ? 1200 : 2500) + noise(random) : 0);
  return depth;
}

struct Seen {
  DepthImage depth;
  Image<std::uint8_t> fillable;
  Cells cells;

  explicit Seen(DepthImage image)
      : depth(std::move(image)),
        fillable(depth.width(), depth.height()),
        cells(depth.width(), depth.height()) {
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) fillable.data()[i] = depth.data()[i] == 0;
    cells.see(depth, fillable, steps_times_units(DepthUnit::kMillimetre, kKinectV1Noise));
  }

  std::vector<std::uint16_t> depths_in(int column, int row) const {
    std::vector<std::uint16_t> found;
    for (int y = row * kCellPx; y < std::min((row + 1) * kCellPx, depth.height()); ++y) {
      for (int x = column * kCellPx; x < std::min((column + 1) * kCellPx, depth.width()); ++x)
        if (depth(x, y) != 0) found.push_back(depth(x, y));
    }
    return found;
  }
};

TEST(Cells, ReachTheNextCellWithDepthEachOfEightWays) {
  for (const double share : {0.02, 0.08, 0.3}) {
    const Seen seen(scattered(150, 106, 1, share));
    const Cells& cells = seen.cells;
    const auto is_worth_looking = [&](int column, int row) {
      return column >= 0 && row >= 0 && column < cells.columns() && row < cells.rows() &&
             seen.depths_in(column, row).size() >= kCellEnough;
    };
    for (std::size_t d = 0; d < Cells::kDirections.size(); ++d) {
      const auto [dx, dy] = Cells::kDirections[d];
      for (int row = 0; row < cells.rows(); ++row) {
        for (int column = 0; column < cells.columns(); ++column) {
          int expected = 0;
          for (int away = kReachCells; away >= 1; --away)
            if (is_worth_looking(column + away * dx, row + away * dy)) expected = away;
          EXPECT_EQ(cells.reach[d][static_cast<std::size_t>(cells.at(column, row))], expected)
              << column << ' ' << row << " towards " << dx << ' ' << dy;
        }
      }
    }
  }
}

TEST(Cells, CountTheirSurfacesPixelsAndHoles) {
  const Seen seen(scattered(150, 106, 2, 0.6));
  const Cells& cells = seen.cells;
  int with_two = 0;
  for (int row = 0; row < cells.rows(); ++row) {
    for (int column = 0; column < cells.columns(); ++column) {
      const auto depths = seen.depths_in(column, row);
      const auto cell = static_cast<std::size_t>(cells.at(column, row));
      const auto near = std::count_if(depths.begin(), depths.end(), [](auto z) { return z < 2000; });
      const auto far = static_cast<std::ptrdiff_t>(depths.size()) - near;
      const bool has_two = near > 0 && far > 0;
      with_two += has_two;
      EXPECT_EQ(cells.far_count[cell], has_two ? far : near + far) << column << ' ' << row;
      EXPECT_EQ(cells.near_count[cell], has_two ? near : 0) << column << ' ' << row;
      const int pixels = std::min(kCellPx, 150 - column * kCellPx) * std::min(kCellPx, 106 - row * kCellPx);
      EXPECT_EQ(cells.wanted[cell] != 0, depths.size() < static_cast<std::size_t>(pixels))
          << column << ' ' << row;
    }
  }
  EXPECT_GT(with_two, 100);
}

TEST(Cells, HaveDepthAndSlopeOfAPlane) {
  DepthImage depth(160, 120);
  const float steps_per_unit = steps_times_units(DepthUnit::kMillimetre, kKinectV1Noise);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x)  // 0.05 steps a pixel across, -0.02 down
      depth(x, y) = static_cast<std::uint16_t>(steps_per_unit / (150 + 0.05 * x - 0.02 * y) + 0.5);
  }
  const Seen seen(std::move(depth));
  const Cells& cells = seen.cells;
  for (int row = 4; row < cells.rows() - 4; ++row) {
    for (int column = 4; column < cells.columns() - 4; ++column) {
      const auto cell = static_cast<std::size_t>(cells.at(column, row));
      EXPECT_NEAR(cells.slope_x[cell], 0.05, 0.01);
      EXPECT_NEAR(cells.slope_y[cell], -0.02, 0.01);
      EXPECT_NEAR(cells.far[cell], 150 + 0.05 * (4 * column + 1.5) - 0.02 * (4 * row + 1.5), 0.05);
    }
  }
}

}  // namespace
}  // namespace copresence::hole_filling
