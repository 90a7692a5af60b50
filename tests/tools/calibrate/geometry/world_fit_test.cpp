#include "tools/calibrate/geometry/world_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/calibrate/geometry/rig.h"

namespace copresence::calibrate {
namespace {

using testing::HasSubstr;

std::vector<Observation> without(std::vector<Observation> observations, std::size_t camera,
                                 std::initializer_list<std::size_t> markers) {
  std::erase_if(observations, [&](const Observation& s) {
    return s.camera == camera && std::find(markers.begin(), markers.end(), s.marker) != markers.end();
  });
  return observations;
}

Result<WorldFit> fit(const Rig& rig, const std::vector<Observation>& observations,
                     Solver solver = Solver::kRigid, std::size_t reference = 0) {
  return fit_world(observations, rig.names(), {reference, rig.world_from_camera[reference], solver});
}

TEST(WorldFit, FindsEveryCameraWithoutNoise) {
  const Rig rig = make_rig(1, 4);
  std::vector<Observation> exact;
  for (Observation s : observations_with_noise(rig, 0)) exact.push_back(s);
  for (const Solver solver : {Solver::kRigid, Solver::kLinear}) {
    const auto world = fit(rig, exact, solver, 2);
    ASSERT_TRUE(world) << world.error().what;
    for (std::size_t c = 0; c < 4; ++c) {
      EXPECT_LT(pose_error(rig, c, world->cameras[c].world_from_camera).shift_mm, 2.5)
          << c;  // The rays have an error of a tenth of a pixel.
    }
    EXPECT_EQ(world->cameras[2].world_from_camera, rig.world_from_camera[2]);
    EXPECT_EQ(world->pairs.size(), 6u);
  }
}

TEST(WorldFit, JoinsCamerasThatShareNoMarkerThroughOthers) {
  const Rig rig = make_rig(7, 3, 10);
  // Camera 0 sees markers 0 to 5, camera 2 sees 4 to 9, and camera 1 sees all. Cameras 0 and 2
  // share too few.
  const auto observations =
      without(without(observations_with_noise(rig, 0.2), 0, {6, 7, 8, 9}), 2, {0, 1, 2, 3});
  const auto world = fit(rig, observations);
  ASSERT_TRUE(world) << world.error().what;
  EXPECT_EQ(world->pairs.size(), 2u);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_LT(pose_error(rig, c, world->cameras[c].world_from_camera).shift_mm, 12) << c;
  }
}

TEST(WorldFit, ClosesLoopsBetterThanAChainOfPairs) {
  double jointly = 0, chained = 0;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const Rig rig = make_rig(seed, 4);
    const auto observations = observations_with_noise(rig, 0.3);
    const auto joint = fit(rig, observations), chain = fit(rig, observations, Solver::kLinear);
    ASSERT_TRUE(joint && chain);
    for (std::size_t c = 1; c < 4; ++c) {
      jointly += pose_error(rig, c, joint->cameras[c].world_from_camera).shift_mm;
      chained += pose_error(rig, c, chain->cameras[c].world_from_camera).shift_mm;
    }
  }
  EXPECT_LT(jointly, 0.5 * chained);
}

TEST(WorldFit, NamesTheMarkerThatWasMoved) {
  const Rig rig = make_rig(11, 3);
  auto observations = observations_with_noise(rig, 0.2);
  for (Observation& s : observations) {
    if (s.camera == 1 && s.marker == 4) s.z_m += 0.15;
  }
  const auto world = fit(rig, observations);
  ASSERT_TRUE(world) << world.error().what;
  EXPECT_EQ(world->cameras[1].residual.worst_at, 4u);
  EXPECT_GT(world->cameras[1].residual.worst, 0.05);
  EXPECT_EQ(world->cameras[1].leave_one_out.worst_at, 4u);
  EXPECT_NEAR(world->cameras[1].leave_one_out.worst, 0.15, 0.04);
  // and that marker hardly changes the pose
  EXPECT_LT(pose_error(rig, 1, world->cameras[1].world_from_camera).shift_mm, 8);
}

TEST(WorldFit, SaysWhichCamerasShareTooLittle) {
  const Rig rig = make_rig(3, 3);
  const auto few = without(observations_with_noise(rig, 0.2), 2, {0, 1, 5});
  const auto world = fit(rig, few);
  ASSERT_FALSE(world);
  EXPECT_THAT(world.error().what, HasSubstr("camera2 see only 3 markers (2, 3 and 4) in common"));
  EXPECT_FALSE(fit(rig, {}));
}

TEST(WorldFit, TakesFourMarkersAndTheWorldsFrameFromTheReference) {
  const Rig rig = make_rig(5, 2, 4);
  const auto world = fit(rig, observations_with_noise(rig, 0.2), Solver::kRigid, 1);
  ASSERT_TRUE(world) << world.error().what;
  EXPECT_EQ(world->cameras[1].world_from_camera, rig.world_from_camera[1]);
  EXPECT_EQ(world->cameras[1].expected_shift_m, 0);
  EXPECT_EQ(world->cameras[0].residual.count, 4u);
  EXPECT_EQ(world->cameras[0].leave_one_out.count, 4u);
  for (const MarkerFit& marker : world->markers) EXPECT_EQ(marker.residual.count, 2u);
  for (std::size_t m = 0; m < 4; ++m) {
    EXPECT_LT((world->markers[m].in_world - rig.world_from_marker[m].translation).norm(), 0.02);
  }
}

}  // namespace
}  // namespace copresence::calibrate
