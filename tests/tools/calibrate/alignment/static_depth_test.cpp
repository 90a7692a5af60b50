#include "tools/calibrate/alignment/static_depth.h"

#include <gtest/gtest.h>

#include <vector>

namespace copresence::alignment {
namespace {

std::vector<DepthImage> frames_of(const std::vector<std::uint16_t>& values) {
  std::vector<DepthImage> frames;
  for (const std::uint16_t value : values) frames.emplace_back(2, 2, value);
  return frames;
}

float average(const std::vector<std::uint16_t>& values) {
  return static_depth(frames_of(values), DepthUnit::kMillimetre)(0, 0);
}

TEST(StaticDepth, OneFrameIsItself) {
  EXPECT_NEAR(average({2000}), 2.0, 1e-6);
}

TEST(StaticDepth, FlickerBetweenTwoLevelsBecomesTheirMean) {
  EXPECT_NEAR(average({2000, 2011, 2000, 2011}), 2.0055, 1e-4);
}

TEST(StaticDepth, OutliersAreLeftOut) {
  EXPECT_NEAR(average({2000, 2000, 2000, 1200, 2000, 2000}), 2.0, 1e-6);
}

TEST(StaticDepth, WhatMovesHasNone) {
  EXPECT_EQ(average({2000, 1900, 1800, 1700, 1600, 1500}), 0);
  EXPECT_EQ(average({2000, 2000, 2000, 1500, 1500}), 0);
}

TEST(StaticDepth, WhatIsMostlyAHoleHasNone) {
  EXPECT_EQ(average({0, 0, 2000}), 0);
  EXPECT_EQ(average({0, 0}), 0);
  EXPECT_NEAR(average({0, 2000, 2000}), 2.0, 1e-6);
}

TEST(StaticDepth, TellsHowMuchWasUnsteady) {
  std::vector<DepthImage> frames = frames_of({2000, 2000, 2000, 2000});
  frames[1](0, 0) = frames[2](0, 0) = 1500;          // something passed
  for (DepthImage& frame : frames) frame(1, 1) = 0;  // never measured: says nothing
  const Image<float> mean = static_depth(frames, DepthUnit::kMillimetre);
  EXPECT_NEAR(unsteady_share(frames, mean), 1.0 / 3, 1e-9);
}

TEST(StaticDepth, TellsHowMuchWasMeasured) {
  EXPECT_NEAR(measured_share(frames_of({2000, 0, 0, 1500})), 0.5, 1e-9);
}

TEST(StaticDepth, KnowsTheUnit) {
  EXPECT_NEAR(static_depth(frames_of({20000}), DepthUnit::k100Micrometres)(1, 1), 2.0, 1e-6);
}

}  // namespace
}  // namespace copresence::alignment
