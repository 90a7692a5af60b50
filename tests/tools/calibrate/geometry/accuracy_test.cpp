// Required accuracy of marker calibration, on 50 random layouts of two to four cameras with a
// Kinect's noise. The calibration benchmark prints the figures for all 50.

#include <gtest/gtest.h>

#include "tests/tools/calibrate/geometry/rig.h"

namespace copresence::calibrate {
namespace {

class MarkerAccuracy : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(MarkerAccuracy, IsWithinTheFiguresOnSeededLayouts) {
  const LayoutErrors errors = run_layouts(GetParam().first, GetParam().second, 3);
  const Errors& rigid = errors.rigid;
  EXPECT_EQ(errors.refused, 0);
  EXPECT_LE(Errors::at(rigid.shift_mm, 0.5), 4);
  EXPECT_LE(Errors::at(rigid.shift_mm, 0.95), 10);
  EXPECT_LE(Errors::at(rigid.angle_deg, 0.5), 0.15);
  EXPECT_LE(Errors::at(rigid.angle_deg, 0.95), 0.3);
  EXPECT_LT(Errors::at(rigid.shift_mm, 0.5), Errors::at(errors.linear.shift_mm, 0.5));
  // Depth by a plane has about half the error of the pixel at the centre.
  EXPECT_LT(errors.plane_steps, 0.6 * errors.pixel_steps);
  // The expected error is close to the true one.
  EXPECT_GT(rigid.expected_over_actual(), 0.6);
  EXPECT_LT(rigid.expected_over_actual(), 2.5);
}

INSTANTIATE_TEST_SUITE_P(Layouts, MarkerAccuracy,
                         testing::Values(std::pair(0, 9), std::pair(9, 18), std::pair(18, 26),
                                         std::pair(26, 34), std::pair(34, 42), std::pair(42, 50)));

}  // namespace
}  // namespace copresence::calibrate
