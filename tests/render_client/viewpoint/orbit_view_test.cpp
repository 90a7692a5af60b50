#include "render_client/viewpoint/orbit_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render_client/viewpoint/look_at.h"

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

/// An eye at the origin that looks along z at a pivot two metres away.
class Orbiting : public testing::Test {
 protected:
  Rigid3 eye() { return view.at(0, {}).world_from_eye; }
  Vector3d forward() { return eye().rotation.col(2); }
  /// Position of a point in the picture, in picture heights from the middle.
  Eigen::Vector2d seen(const Vector3d& point) {
    const Vector3d p = eye().inverse() * point;
    return p.head<2>() / p.z() / (2 * std::tan(25 * std::numbers::pi / 180));
  }

  OrbitView view{camera_from_field_of_view(640, 480, 50 * std::numbers::pi / 180), {0, -1, 0}, 2.0};
  const Vector3d pivot{0, 0, 2};
};

TEST_F(Orbiting, StartsAtHome) {
  EXPECT_EQ(eye(), Rigid3{});
}

TEST_F(Orbiting, CirclesThePivotAtTheSameDistance) {
  view.apply(Orbit{0.2, -0.1});
  view.apply(Orbit{-0.7, 0.3});
  EXPECT_NEAR((eye().translation - pivot).norm(), 2, 1e-12);
  EXPECT_TRUE((eye().inverse() * pivot).isApprox(Vector3d(0, 0, 2), 1e-9));
  EXPECT_TRUE(eye().is_rigid(1e-9));
}

TEST_F(Orbiting, TurnsTheSceneWithThePointer) {
  const Vector3d front(0, 0, 1.5);  // nearer than the pivot
  view.apply(Orbit{0.05, 0});
  EXPECT_GT(seen(front).x(), 0.01);
  view.apply(ResetPose{});
  view.apply(Orbit{0, 0.05});
  EXPECT_GT(seen(front).y(), 0.01);
}

TEST_F(Orbiting, OverTheWholeHeightIsHalfATurn) {
  view.apply(Orbit{1, 0});
  EXPECT_TRUE(eye().translation.isApprox(Vector3d(0, 0, 4), 1e-9));
  EXPECT_TRUE(forward().isApprox(Vector3d(0, 0, -1), 1e-9));
}

TEST_F(Orbiting, NeverGoesOverTheTop) {
  for (int i = 0; i < 10; ++i) view.apply(Orbit{0.01, 0.3});
  EXPECT_LT(forward().dot(Vector3d(0, 1, 0)), 1);
  EXPECT_GT(forward().dot(Vector3d(0, 1, 0)), 0.99);
  EXPECT_TRUE(eye().is_rigid(1e-9));
  for (int i = 0; i < 10; ++i) view.apply(Orbit{0, -0.3});
  EXPECT_LT(forward().dot(Vector3d(0, 1, 0)), -0.99);
  view.apply(Orbit{0, 0.5});
  EXPECT_NEAR(forward().y(), 0, 0.05);
}

TEST_F(Orbiting, KeepsTheHorizonLevel) {
  for (int i = 0; i < 50; ++i) view.apply(Orbit{0.1 * std::sin(i), 0.05 * std::cos(i)});
  EXPECT_NEAR(eye().rotation.col(0).y(), 0, 1e-9);
}

TEST_F(Orbiting, PansWithWhatIsUnderThePointer) {
  view.apply(Pan{0.25, -0.1});
  EXPECT_NEAR(seen(pivot).x(), 0.25, 1e-12);
  EXPECT_NEAR(seen(pivot).y(), -0.1, 1e-12);
  EXPECT_TRUE(eye().rotation.isIdentity(1e-12));
}

TEST_F(Orbiting, ZoomsTowardsThePivotAndNeverThroughIt) {
  view.apply(Zoom{1});
  EXPECT_NEAR(eye().translation.z(), 0.2, 1e-12);
  view.apply(Zoom{-1});
  EXPECT_NEAR(eye().translation.z(), 0, 1e-12);
  for (int i = 0; i < 500; ++i) view.apply(Zoom{3});
  EXPECT_LT(eye().translation.z(), 2);
  for (int i = 0; i < 500; ++i) view.apply(Zoom{-3});
  EXPECT_GT(eye().translation.z(), -40);
}

TEST_F(Orbiting, TakesItsFirstHome) {
  view.apply(Orbit{0.3, 0.1});
  const Rigid3 home = look_at({1, 0, 0}, {0, 0, 0}, {0, -1, 0});
  view.set_reset_pose(home);
  EXPECT_EQ(eye(), home);
  view.apply(Zoom{4});
  view.apply(ResetPose{});
  EXPECT_EQ(eye(), home);
}

TEST_F(Orbiting, FollowsALaterHomeOnlyWhileItIsAtHome) {
  const Rigid3 first = look_at({1, 0, 0}, {0, 0, 0}, {0, -1, 0});
  const Rigid3 second = look_at({0, 0, 1}, {0, 0, 0}, {0, -1, 0});
  const Rigid3 third = look_at({-1, 0, 0}, {0, 0, 0}, {0, -1, 0});
  view.set_reset_pose(first);
  view.set_reset_pose(second);
  EXPECT_EQ(eye(), second);
  view.apply(Pan{0.1, 0});
  const Rigid3 moved = eye();
  view.set_reset_pose(third);
  EXPECT_EQ(eye(), moved);
  view.apply(ResetPose{});
  EXPECT_EQ(eye(), third);
}

TEST_F(Orbiting, DoesNotJumpFromAHomeThatLooksStraightDown) {
  view.set_reset_pose(look_at({0, -2, 0}, {0, 0, 0}, {0, -1, 0}));
  const Rigid3 before = eye();
  view.apply(Orbit{0, 0.001});
  EXPECT_TRUE(eye().translation.isApprox(before.translation, 0.01));
  EXPECT_TRUE(eye().is_rigid(1e-9));
}

}  // namespace
}  // namespace copresence::viewpoint
