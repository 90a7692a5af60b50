#include "common/frame/rigid3.h"

#include <gtest/gtest.h>

#include <limits>

namespace copresence {
namespace {

Rigid3 some_pose() {
  return {Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
          Eigen::Vector3d(0.1, -2, 3)};
}

TEST(Rigid3, InverseUndoesIt) {
  const Eigen::Vector3d point(1, 2, 3);
  EXPECT_TRUE((some_pose().inverse() * (some_pose() * point)).isApprox(point));
}

TEST(Rigid3, ChainsLikeItsMatrices) {
  const Rigid3 a_from_b = some_pose(), b_from_c = some_pose().inverse() * some_pose() * some_pose();
  EXPECT_TRUE((a_from_b * b_from_c).matrix().isApprox(a_from_b.matrix() * b_from_c.matrix()));
}

TEST(Rigid3, TellsARotationFromAnythingElse) {
  EXPECT_TRUE(some_pose().is_rigid());
  Rigid3 scaled = some_pose();
  scaled.rotation *= 1.1;
  EXPECT_FALSE(scaled.is_rigid());
  Rigid3 mirrored;
  mirrored.rotation(0, 0) = -1;
  EXPECT_FALSE(mirrored.is_rigid());
  Rigid3 nowhere;
  nowhere.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(nowhere.is_rigid());
}

}  // namespace
}  // namespace copresence
