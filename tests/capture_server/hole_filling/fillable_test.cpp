#include "capture_server/hole_filling/fillable.h"

#include <gtest/gtest.h>

namespace copresence::hole_filling {
namespace {

StateImage measured_except(int width, int height, int left, int top, int right, int bottom) {
  StateImage state(width, height, DepthState::kMeasured);
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) state(x, y) = DepthState::kHole;
  }
  return state;
}

int fillable_pixels(const StateImage& state, int widest, int widest_at_border = 0) {
  Image<std::uint8_t> fillable;
  find_fillable(state, widest, widest_at_border, fillable);
  int count = 0;
  for (const std::uint8_t pixel : fillable.pixels()) count += pixel;
  return count;
}

TEST(Fillable, TakesRunsUpToTheWidestAlongEitherAxis) {
  EXPECT_EQ(fillable_pixels(measured_except(80, 60, 10, 10, 30, 50), 20), 20 * 40);
  EXPECT_EQ(fillable_pixels(measured_except(80, 60, 10, 10, 31, 50), 20), 0);
  EXPECT_EQ(fillable_pixels(measured_except(80, 60, 10, 10, 70, 30), 20), 60 * 20);
}

TEST(Fillable, TakesNarrowBandsAtTheBorder) {
  for (const int band : {1, 8, 9}) {
    const bool narrow = band <= 8;
    EXPECT_EQ(fillable_pixels(measured_except(80, 60, 0, 0, band, 60), 20, 8), narrow ? band * 60 : 0);
    EXPECT_EQ(fillable_pixels(measured_except(80, 60, 80 - band, 0, 80, 60), 20, 8), narrow ? band * 60 : 0);
    EXPECT_EQ(fillable_pixels(measured_except(80, 60, 0, 0, 80, band), 20, 8), narrow ? band * 80 : 0);
    EXPECT_EQ(fillable_pixels(measured_except(80, 60, 0, 60 - band, 80, 60), 20, 8), narrow ? band * 80 : 0);
  }
}

TEST(Fillable, TakesNothingBetweenBorderAndBorder) {
  EXPECT_EQ(fillable_pixels(measured_except(8, 6, 0, 0, 8, 6), 20, 10), 0);
  EXPECT_EQ(fillable_pixels(measured_except(80, 6, 0, 0, 80, 6), 254, 127), 0);
}

TEST(Fillable, TakesWhatTouchesTheBorderOnOneAxisOnly) {
  EXPECT_EQ(fillable_pixels(measured_except(80, 60, 10, 0, 20, 60), 20), 10 * 60);
}

TEST(Fillable, CountsRunsLongerThanAByte) {
  EXPECT_EQ(fillable_pixels(measured_except(900, 600, 100, 100, 800, 500), 254), 0);
  EXPECT_EQ(fillable_pixels(measured_except(900, 600, 100, 100, 354, 500), 254), 254 * 400);
}

}  // namespace
}  // namespace copresence::hole_filling
