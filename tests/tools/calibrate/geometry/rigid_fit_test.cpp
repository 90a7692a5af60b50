#include "tools/calibrate/geometry/rigid_fit.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <random>
#include <vector>

namespace copresence::calibrate {
namespace {

const Rigid3 kTruth{Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix(),
                    {0.4, -1.2, 2.5}};

std::vector<PointPair> pairs(int count, double noise = 0, double flat = 1) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1, 1);
  std::normal_distribution<double> error(0, 1);
  std::vector<PointPair> out;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d a(place(random), place(random), flat * place(random));
    out.push_back({a, kTruth * a + noise * Eigen::Vector3d(error(random), error(random), error(random))});
  }
  return out;
}

double distance(const Rigid3& a, const Rigid3& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(RigidFit, FindsThePoseOfExactPoints) {
  EXPECT_LT(distance(fit_rigid(pairs(3)), kTruth), 1e-12);
  EXPECT_LT(distance(fit_rigid(pairs(20)), kTruth), 1e-12);
  EXPECT_LT(distance(fit_rigid(pairs(5, 0, 0)), kTruth),
            1e-12);  // Points in one plane must not give the mirror image.
}

TEST(RigidFit, LeavesOutPointsOfNoWeight) {
  auto some = pairs(6);
  some[2].in_b += Eigen::Vector3d(0.3, 0, 0);
  EXPECT_GT(distance(fit_rigid(some), kTruth), 1e-2);
  some[2].weight = 1e-12;
  EXPECT_LT(distance(fit_rigid(some), kTruth), 1e-9);
}

TEST(RigidFit, StaysARotationUnderNoise) {
  const Rigid3 fit = fit_rigid(pairs(4, 0.1));
  EXPECT_TRUE(fit.is_rigid(1e-12));
  EXPECT_NEAR(rms_distance(kTruth, pairs(2000, 0.1)), 0.1 * std::sqrt(3.0), 0.01);
}

TEST(LinearFit, FindsTheTwelveUnknownsOfFourPoints) {
  const LinearFit fit = fit_linear(pairs(4));
  EXPECT_LT((fit.b_from_a - kTruth.matrix().topRows<3>()).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT(distance(fit.rigid, kTruth), 1e-10);
  EXPECT_NEAR(fit.least_scale, 1, 1e-10);
  EXPECT_NEAR(fit.most_scale, 1, 1e-10);
}

TEST(LinearFit, TakesNoiseForScaleAndShearWhereTheRigidFitDoesNot) {
  const auto noisy = pairs(5, 0.02);
  const LinearFit fit = fit_linear(noisy);
  EXPECT_GT(fit.most_scale - fit.least_scale, 0.01);
  EXPECT_TRUE(fit.rigid.is_rigid(1e-12));
  EXPECT_GE(rms_distance(fit.rigid, noisy), rms_distance(fit_rigid(noisy), noisy));
}

}  // namespace
}  // namespace copresence::calibrate
