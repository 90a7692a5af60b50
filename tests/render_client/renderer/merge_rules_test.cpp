#include "render_client/renderer/merge_rules.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <numbers>

namespace copresence::renderer {
namespace {

const SurfaceLimits kLimits(kKinectV1Noise, 1.0F / 585);

bool connected_at(double a_m, double b_m) {
  return connected(float(1 / a_m), float(1 / b_m), float(1 / b_m), kLimits);
}

TEST(MergeRules, JoinNeighboursThatNoiseAndTiltExplain) {
  for (double z : {0.5, 1.0, 2.0, 3.0, 4.0}) {
    EXPECT_TRUE(connected_at(z, z + 3 * kKinectV1Noise.step_m(z))) << z;
    const double tilted = z * std::tan(75 * std::numbers::pi / 180) / 585;
    EXPECT_TRUE(connected_at(z, z + tilted)) << z;
  }
}

TEST(MergeRules, SeparateAHandFromTheWallBehindIt) {
  EXPECT_FALSE(connected_at(0.5, 0.52));
  EXPECT_FALSE(connected_at(1.0, 1.05));
  EXPECT_FALSE(connected_at(2.0, 2.15));
  EXPECT_FALSE(connected_at(3.0, 3.4));
}

TEST(MergeRules, DoNotCareInWhichOrderThePixelsCome) {
  const float a = 0.5F, b = 0.51F, c = 0.48F;
  EXPECT_EQ(connected(a, b, c, kLimits), connected(c, b, a, kLimits));
  EXPECT_EQ(connected(a, b, c, kLimits), connected(b, c, a, kLimits));
}

TEST(MergeRules, FindTheTiltOfAPlane) {
  // The plane n.P = d, seen along several rays.
  for (double degrees : {0.0, 30.0, 60.0, 80.0}) {
    const double tilt = degrees * std::numbers::pi / 180;
    const Eigen::Vector3d n(std::sin(tilt), 0, std::cos(tilt));
    for (double x : {-0.3, 0.0, 0.4}) {
      const Eigen::Vector3d ray(x, 0.2, 1);
      const double incidence = n.dot(ray) / ray.norm();
      if (incidence < 0.05) continue;
      const double d = 2;
      EXPECT_NEAR(cos_theta(float(n.dot(ray) / d), float(n.x() / d), float(n.y() / d), float(x), 0.2F),
                  incidence, 1e-5);
    }
  }
}

TEST(MergeRules, TakeTheRangeFromBothSensorsNoiseAtTheirDistance) {
  // 3 (5.7 + 5.7) + 10 = 44 mm for two Kinects at 2 m, calibrated to 5 mm each.
  EXPECT_NEAR(2 * uncertainty_m(2, 0.005F, kKinectV1Noise), 0.044, 0.0005);
  EXPECT_NEAR(uncertainty_m(3, 0.004F, kKinectV1Noise), 3 * kKinectV1Noise.sigma_m(3) + 0.004, 1e-6);
}

TEST(MergeRules, LetAFragmentFadeBeforeItLeavesTheRange) {
  EXPECT_FLOAT_EQ(blend_weight(2, 0, 0.04F), 2);
  EXPECT_FLOAT_EQ(blend_weight(2, 0.02F, 0.04F), 2);
  EXPECT_FLOAT_EQ(blend_weight(2, 0.03F, 0.04F), 1);
  EXPECT_FLOAT_EQ(blend_weight(2, 0.04F, 0.04F), 0);
  EXPECT_FLOAT_EQ(blend_weight(2, 0.05F, 0.04F), 0);
}

TEST(MergeRules, BlendEqualsEvenlyAndLeaveOutTheMuchWorse) {
  EXPECT_FLOAT_EQ(blend_share(3, 3), 1);
  EXPECT_FLOAT_EQ(blend_share(3 * kTieRatio, 3), 0);
  EXPECT_FLOAT_EQ(blend_share(0.1F, 3), 0);
  EXPECT_NEAR(blend_share(3 * 0.5F * (1 + kTieRatio), 3), 0.5, 1e-5);
}

TEST(MergeRules, ValueMeasuredAboveFilledAndNearAboveFar) {
  const auto quality = [](float incidence, float z_m, DepthState state) {
    return quality_index(incidence, z_m, state, kKinectV1Noise);
  };
  EXPECT_GT(quality(1, 2, DepthState::kMeasured), quality(1, 2, DepthState::kFilled));
  EXPECT_GT(quality(1, 2, DepthState::kMeasured), quality(1, 3, DepthState::kMeasured));
  EXPECT_FLOAT_EQ(quality(0.5F, 2, DepthState::kMeasured), 0.125F);
}

TEST(MergeRules, FollowTheSensorsNoise) {
  const DepthNoise coarse{.disparity_constant_m = 100, .sigma_steps = 1};
  EXPECT_FALSE(connected_at(1.0, 1.05));
  EXPECT_TRUE(connected(1, float(1 / 1.05), float(1 / 1.05), SurfaceLimits(coarse, 1.0F / 585)));
  EXPECT_NEAR(uncertainty_m(3, 0.004F, coarse), 3 * coarse.sigma_m(3) + 0.004, 1e-6);
  // A sensor with a seventh of a Kinect's precision has a seventh of its weight.
  EXPECT_NEAR(quality_index(1, 1, DepthState::kMeasured, coarse), 0.5 / 3.513, 1e-4);
}

}  // namespace
}  // namespace copresence::renderer
