#include "render_client/viewpoint/look_at.h"

#include <gtest/gtest.h>

#include "render_client/viewpoint/scripted_views.h"

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

const Vector3d kUp{0, -1, 0};

TEST(LookAt, AlongTheWorldsAxesIsTheWorldsFrame) {
  const Rigid3 pose = look_at({1, 2, 3}, {1, 2, 8}, kUp);
  EXPECT_TRUE(pose.rotation.isIdentity(1e-12));
  EXPECT_EQ(pose.translation, Vector3d(1, 2, 3));
}

TEST(LookAt, PutsTheTargetOnTheAxisAndUpUpward) {
  for (const Vector3d& up : {kUp, Vector3d(0, 0, 3), Vector3d(1, 1, 0)}) {
    const Vector3d eye(0.3, -0.2, 0.1), target(2, 1, -1);
    const Rigid3 pose = look_at(eye, target, up);
    ASSERT_TRUE(pose.is_rigid(1e-12));
    const Vector3d seen = pose.inverse() * target;
    EXPECT_TRUE(seen.isApprox(Vector3d(0, 0, (target - eye).norm()), 1e-12));
    const Vector3d up_seen = pose.rotation.transpose() * up;
    EXPECT_NEAR(up_seen.x(), 0, 1e-12);
    EXPECT_LT(up_seen.y(), 0);
  }
}

TEST(LookAt, StaysRigidWhereTheDirectionsSayNothing) {
  const Vector3d eye(1, 2, 3);
  for (const auto& [target, up] : {std::pair<Vector3d, Vector3d>{{1, 9, 3}, kUp},
                                   {{1, -9, 3}, kUp},
                                   {eye, kUp},
                                   {{4, 4, 4}, {0, 0, 0}},
                                   {eye, {0, 0, 0}},
                                   {{1, 2 + 1e-12, 3}, kUp}}) {
    const Rigid3 pose = look_at(eye, target, up);
    EXPECT_TRUE(pose.is_rigid(1e-12));
    EXPECT_EQ(pose.translation, eye);
    EXPECT_GE((pose.inverse() * target).z(), -1e-9);
  }
}

TEST(FixedView, StaysAtHome) {
  FixedView view({});
  EXPECT_EQ(view.at(0, {}).world_from_eye, Rigid3{});
  const Rigid3 home = look_at({1, 0, 0}, {0, 0, 0}, kUp);
  view.set_reset_pose(home);
  EXPECT_EQ(view.at(7, Instant(Duration(9))).world_from_eye, home);
}

}  // namespace
}  // namespace copresence::viewpoint
