#include "tools/calibrate/geometry/plane_depth.h"

#include <gtest/gtest.h>

#include <vector>

namespace copresence::calibrate {
namespace {

DepthAverage average_of(const std::vector<std::uint16_t>& values, DepthUnit unit = DepthUnit::kMillimetre) {
  DepthAverage average(unit);
  for (const std::uint16_t value : values) average.add(DepthImage(2, 2, value));
  return average;
}

float average(const std::vector<std::uint16_t>& values) {
  return average_of(values).still_depth()(0, 0);
}

TEST(DepthAverage, OneFrameIsItself) {
  EXPECT_NEAR(average({2000}), 2.0, 1e-6);
}

TEST(DepthAverage, FlickerBetweenTwoLevelsBecomesTheirMean) {
  EXPECT_NEAR(average({2000, 2011, 2000, 2011}), 2.0055, 1e-4);
}

TEST(DepthAverage, OutliersAreLeftOut) {
  EXPECT_NEAR(average({1200, 2000, 2000, 2000, 2000, 2000, 2000}), 2.0, 1e-6) << "also at the beginning";
  EXPECT_NEAR(average({2000, 2000, 2000, 1200, 2000, 2000}), 2.0, 1e-6);
}

TEST(DepthAverage, WhatMovesHasNone) {
  EXPECT_EQ(average({2000, 1900, 1800, 1700, 1600, 1500}), 0);
  EXPECT_EQ(average({2000, 2000, 2000, 1500, 1500}), 0);
}

TEST(DepthAverage, WhatIsMostlyAHoleHasNone) {
  EXPECT_EQ(average({0, 0, 2000}), 0);
  EXPECT_EQ(average({0, 0}), 0);
  EXPECT_NEAR(average({0, 2000, 2000}), 2.0, 1e-6);
}

TEST(DepthAverage, TellsHowMuchWasUnsteady) {
  DepthAverage average(DepthUnit::kMillimetre);
  // An object passes at the first pixel.
  for (const std::uint16_t first : std::vector<std::uint16_t>{2000, 1500, 1500, 2000}) {
    DepthImage depth(2, 2, 2000);
    depth(0, 0) = first;
    depth(1, 1) = 0;  // Never measured: does not count.
    average.add(depth);
  }
  EXPECT_NEAR(average.unsteady_share(), 1.0 / 3, 1e-9);
}

TEST(DepthAverage, TellsHowMuchWasMeasured) {
  EXPECT_NEAR(average_of({2000, 0, 0, 1500}).measured_share(), 0.5, 1e-9);
}

TEST(DepthAverage, KnowsTheUnit) {
  EXPECT_NEAR(average_of({20000}, DepthUnit::k100Micrometres).still_depth()(1, 1), 2.0, 1e-6);
}

}  // namespace
}  // namespace copresence::calibrate
