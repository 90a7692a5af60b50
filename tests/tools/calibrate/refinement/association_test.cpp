#include "tools/calibrate/refinement/association.h"

#include <gtest/gtest.h>

#include "tests/tools/calibrate/refinement/scenes.h"

namespace copresence::calibrate {
namespace {

struct TwoCameras {
  Rigid3 left = test::look_from({-0.7, -1.3, -1.2}, {0, -0.6, 1});
  Rigid3 right = test::look_from({0.7, -1.3, -1.2}, {0, -0.6, 1});
  Surface seen_left =
      make_surface(test::depth_of(test::furnished_room(), test::small_camera(), left), test::small_camera());
  Surface seen_right =
      make_surface(test::depth_of(test::furnished_room(), test::small_camera(), right), test::small_camera());
};

TEST(Agreement, IsCompleteWhereThePosesAreTrue) {
  const TwoCameras two;
  const Agreement agreement = measure_agreement(two.seen_left, two.left, two.seen_right, two.right);
  EXPECT_GT(agreement.overlap, 0.5);
  EXPECT_LT(agreement.median_m, 0.0005);
  EXPECT_LT(agreement.p95_m, 0.003);
  EXPECT_LT(agreement.contradicted, 0.005);
}

TEST(Agreement, OneCameraAgreesWithItself) {
  const TwoCameras two;
  const Agreement agreement = measure_agreement(two.seen_left, two.left, two.seen_left, two.left);
  EXPECT_DOUBLE_EQ(agreement.overlap, 1);
  EXPECT_LT(agreement.p95_m, 1e-6);
  EXPECT_NEAR(agreement.score, 1, 1e-6);
}

TEST(Agreement, ShowsAShiftAcrossAWallInMillimetresAndSigmas) {
  const std::vector<test::Box> wall{{{-9, -9, -9}, {9, 9, 2}}};
  const Surface surface = make_surface(test::depth_of(wall, test::small_camera(), {}), test::small_camera());
  const Agreement agreement =
      measure_agreement(surface, {}, surface, {Eigen::Matrix3d::Identity(), {0, 0, 0.02}});
  EXPECT_NEAR(agreement.median_m, 0.02, 0.001);
  EXPECT_NEAR(agreement.median_sigmas, 0.02 / (std::sqrt(2.0) * kKinectV1Noise.sigma_m(2)), 1.0);
}

TEST(Agreement, FallsWithTheDistanceFromTheTruth) {
  const TwoCameras two;
  double before = 1;
  for (const double shift : {0.0, 0.02, 0.05, 0.1}) {
    const Rigid3 off = test::disturbed(two.right, {shift, 0, shift}, {0, 1, 0}, 0);
    const double score = measure_agreement(two.seen_left, two.left, two.seen_right, off).score;
    EXPECT_LT(score, before) << shift;
    before = score;
  }
}

TEST(Agreement, CountsWhatOneCameraLooksThrough) {
  const std::vector<test::Box> near{{{-9, -9, -9}, {9, 9, 1}}}, far{{{-9, -9, -9}, {9, 9, 3}}};
  const Surface close = make_surface(test::depth_of(near, test::small_camera(), {}), test::small_camera());
  const Surface distant = make_surface(test::depth_of(far, test::small_camera(), {}), test::small_camera());
  const Agreement agreement = measure_agreement(close, {}, distant, {});
  EXPECT_EQ(agreement.points, 0);
  EXPECT_DOUBLE_EQ(agreement.contradicted, 1);
  EXPECT_LT(agreement.score, 0);
}

TEST(Agreement, OfCamerasBackToBackIsNothing) {
  const TwoCameras two;
  const Rigid3 away = test::look_from({0.7, -1.3, -1.2}, {2, -0.6, -3});
  const Agreement agreement = measure_agreement(two.seen_left, two.left, two.seen_right, away);
  EXPECT_LT(agreement.overlap, 0.05);
}

}  // namespace
}  // namespace copresence::calibrate
