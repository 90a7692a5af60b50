#include "tools/calibrate/refinement/refinement.h"

#include <gtest/gtest.h>

#include "tests/tools/calibrate/refinement/scenes.h"

namespace copresence::calibrate {
namespace {

using Outcome = CameraRefinement::Outcome;

// Both look into the corner of the room, so both see walls in all three directions.
const Eigen::Vector3d kCorner(1.0, -0.5, 1.8);
const Rigid3 kLeft = test::look_from({-0.9, -1.5, -0.6}, kCorner);
const Rigid3 kRight = test::look_from({0.3, -1.3, -1.0}, kCorner);

std::vector<double> nothing_known(const std::vector<Rigid3>& poses) {
  return std::vector<double>(poses.size(), 0.0);
}

Surface seen(const std::vector<test::Box>& boxes, const Rigid3& pose, unsigned seed = 0) {
  return make_surface(test::depth_of(boxes, test::small_camera(), pose, seed), test::small_camera());
}

TEST(Refinement, FindsThePoseAgainFromTenCentimetresAndFiveDegreesOff) {
  const std::vector<Surface> surfaces{seen(test::furnished_room(), kLeft),
                                      seen(test::furnished_room(), kRight)};
  const std::vector<Rigid3> given{kLeft, test::disturbed(kRight, {0.06, -0.05, 0.06}, {1, 1, -1}, 5)};
  const Refinement refined = refine(surfaces, given, nothing_known(given));
  EXPECT_EQ(refined.cameras[0].outcome, Outcome::kReference);
  EXPECT_EQ(refined.cameras[0].world_from_camera, kLeft);
  EXPECT_EQ(refined.cameras[1].outcome, Outcome::kRefined);
  EXPECT_LT(test::millimetres_between(refined.cameras[1].world_from_camera, kRight), 1);
  EXPECT_LT(test::degrees_between(refined.cameras[1].world_from_camera, kRight), 0.05);
  EXPECT_NEAR(refined.cameras[1].moved_mm, 100, 3);
  EXPECT_NEAR(refined.cameras[1].moved_deg, 5, 0.1);
  ASSERT_EQ(refined.pairs.size(), 1u);
  EXPECT_LT(refined.pairs[0].after.rms_m, 0.2 * refined.pairs[0].before.rms_m);
}

TEST(Refinement, EndsInOnePlaceWhereverItStarts) {
  const std::vector<Surface> surfaces{seen(test::furnished_room(), kLeft, 1),
                                      seen(test::furnished_room(), kRight, 2)};
  const Rigid3 from_truth =
      refine(surfaces, std::vector{kLeft, kRight}, std::vector(2, 0.0)).cameras[1].world_from_camera;
  EXPECT_LT(test::millimetres_between(from_truth, kRight), 8);
  EXPECT_LT(test::degrees_between(from_truth, kRight), 0.3);
  const Rigid3 off = test::disturbed(kRight, {-0.07, 0.06, -0.04}, {-1, 2, 1}, 5);
  const Rigid3 from_afar =
      refine(surfaces, std::vector{kLeft, off}, std::vector(2, 0.0)).cameras[1].world_from_camera;
  EXPECT_LT(test::millimetres_between(from_afar, from_truth), 2);
  EXPECT_LT(test::degrees_between(from_afar, from_truth), 0.1);
}

// Refines two cameras with a Kinect's noise. The right one starts off its pose, with a known error
// of `told_m`.
CameraRefinement refine_told(const Eigen::Vector3d& off, double degrees_off, double prior_m) {
  const std::vector<Surface> surfaces{seen(test::furnished_room(), kLeft, 1),
                                      seen(test::furnished_room(), kRight, 2)};
  const std::vector<Rigid3> given{kLeft, test::disturbed(kRight, off, {0, 1, 0}, degrees_off)};
  return refine(surfaces, given, std::vector{0.0, prior_m}).cameras[1];
}

TEST(Refinement, KeepsAPoseThatIsKnownBetterThanSurfacesTellIt) {
  const CameraRefinement kept = refine_told({0.0003, 0, -0.0003}, 0, 0.0005);
  EXPECT_EQ(kept.outcome, Outcome::kPriorBetter);
  EXPECT_EQ(kept.moved_mm, 0);
  EXPECT_NEAR(kept.moved_deg, 0, 1e-9);
  EXPECT_GT(kept.surfaces_mm, 0.5);
  EXPECT_DOUBLE_EQ(kept.error_mm, 0.5);
}

TEST(Refinement, KeepsAPoseThatSurfacesAloneTellNearlyAsWell) {
  const double alone_m = 1e-3 * refine_told({0.0003, 0, -0.0003}, 0, 0.05).surfaces_mm;
  EXPECT_EQ(refine_told({0.0003, 0, -0.0003}, 0, 0.97 * alone_m).outcome, Outcome::kPriorBetter);
}

TEST(Refinement, ImprovesAPoseThatIsKnownWorseThanSurfacesTellIt) {
  const CameraRefinement moved = refine_told({0.015, 0.01, 0.01}, 0.3, 0.02),
                         freely = refine_told({0.015, 0.01, 0.01}, 0.3, 0);
  EXPECT_EQ(moved.outcome, Outcome::kRefined);
  EXPECT_FALSE(moved.contradicts_prior);
  EXPECT_LT(moved.error_mm, 20);
  EXPECT_LE(moved.error_mm, moved.surfaces_mm);
  EXPECT_LT(test::millimetres_between(moved.world_from_camera, freely.world_from_camera), 2);
}

TEST(Refinement, SaysWhenSurfacesContradictWhatIsToldOfAPose) {
  const CameraRefinement moved = refine_told({0.03, 0.02, 0.02}, 1, 0.0005);
  EXPECT_EQ(moved.outcome, Outcome::kRefined);
  EXPECT_TRUE(moved.contradicts_prior);
  EXPECT_LT(test::millimetres_between(moved.world_from_camera, kRight), 8);
}

TEST(Refinement, KeepsTheTruthWhereOnlyChanceWouldMoveIt) {
  int worse = 0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const std::vector<Surface> surfaces{seen(test::furnished_room(), kLeft, 2 * seed + 7),
                                        seen(test::furnished_room(), kRight, 2 * seed + 8)};
    const std::vector<Rigid3> truth{kLeft, kRight};
    const Refinement refined = refine(surfaces, truth, std::vector{0.0, 0.004});
    worse += refined.cameras[1].moved_mm > 0;
  }
  EXPECT_EQ(worse, 0);
}

TEST(Refinement, MovesAllCamerasTogetherAlongChains) {
  const Rigid3 far_right = test::look_from({1.2, -1.6, -1.0}, kCorner);
  std::vector<Surface> surfaces;
  for (const Rigid3& pose : {kLeft, kRight, far_right})
    surfaces.push_back(seen(test::furnished_room(), pose));
  const std::vector<Rigid3> given{kLeft, test::disturbed(kRight, {0.03, 0, -0.03}, {0, 1, 0}, 2),
                                  test::disturbed(far_right, {0, 0.03, 0.03}, {1, 0, 0}, 2)};
  const Refinement refined = refine(surfaces, given, nothing_known(given));
  EXPECT_LT(test::millimetres_between(refined.cameras[1].world_from_camera, kRight), 2);
  EXPECT_LT(test::millimetres_between(refined.cameras[2].world_from_camera, far_right), 2);
}

TEST(Refinement, DoesNotSlideAlongAWall) {
  const std::vector<test::Box> wall{{{-9, -9, -9}, {9, 9, 2}}};
  const Rigid3 left = test::look_from({-0.4, 0, 0}, {0, 0, 2}),
               right = test::look_from({0.4, 0, 0}, {0, 0, 2});
  const std::vector<Surface> surfaces{seen(wall, left, 1), seen(wall, right, 2)};
  const std::vector<Rigid3> given{left, test::disturbed(right, {0.03, 0.02, 0.04}, {1, 0, 0}, 1)};
  const Refinement refined = refine(surfaces, given, nothing_known(given));
  ASSERT_EQ(refined.cameras[1].outcome, Outcome::kRefined);
  EXPECT_EQ(refined.cameras[1].unobservable.size(), 3u);  // Two shifts and the turn in the wall's plane.
  const Eigen::Vector3d moved =
      refined.cameras[1].world_from_camera * Eigen::Vector3d(0, 0, 2) - right * Eigen::Vector3d(0, 0, 2);
  EXPECT_NEAR(moved.z(), 0, 0.004);  // Moved onto the wall.
  const Eigen::Vector3d as_given = given[1] * Eigen::Vector3d(0, 0, 2) - right * Eigen::Vector3d(0, 0, 2);
  EXPECT_NEAR(moved.x(), as_given.x(), 0.01);  // But not along it.
  EXPECT_NEAR(moved.y(), as_given.y(), 0.01);
  EXPECT_EQ(refined.cameras[1].error_mm, 0) << "nobody knows how far off it is along the wall";
  // A known error still holds there: half of the pose's six parameters did not change.
  const CameraRefinement told = refine(surfaces, given, std::vector{0.0, 0.06}).cameras[1];
  EXPECT_GT(told.error_mm, 30);
}

TEST(Refinement, SaysNoWhereNothingIsSeenInCommon) {
  const Rigid3 away = test::look_from({0.3, -1.3, 0}, {0.2, -1.2, -1.4});
  const std::vector<Surface> surfaces{seen(test::furnished_room(), kLeft),
                                      seen(test::furnished_room(), away)};
  const Refinement refined = refine(surfaces, std::vector{kLeft, away}, std::vector(2, 0.0));
  EXPECT_EQ(refined.cameras[1].outcome, Outcome::kNoOverlap);
  EXPECT_EQ(refined.cameras[1].world_from_camera, away);
}

TEST(Refinement, LeavesACameraUntouchedThatSharesNothingWhileItRefinesTheOthers) {
  const Rigid3 away = test::look_from({0.3, -1.3, 0}, {0.2, -1.2, -1.4});
  std::vector<Surface> surfaces;
  for (const Rigid3& pose : {kLeft, away, kRight}) surfaces.push_back(seen(test::furnished_room(), pose));
  const std::vector<Rigid3> given{kLeft, away, test::disturbed(kRight, {0.03, 0, -0.03}, {0, 1, 0}, 2)};
  const Refinement refined = refine(surfaces, given, nothing_known(given));
  EXPECT_EQ(refined.cameras[1].outcome, Outcome::kNoOverlap);
  EXPECT_EQ(refined.cameras[1].world_from_camera, away);
  EXPECT_EQ(refined.cameras[2].outcome, Outcome::kRefined);
  EXPECT_LT(test::millimetres_between(refined.cameras[2].world_from_camera, kRight), 2);
}

}  // namespace
}  // namespace copresence::calibrate
