#include "capture_server/drivers/contract/simulated_uri.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simulation/scene/scene.h"

namespace copresence::drivers {
namespace {

TEST(SimulatedUri, ReadsWhatItIsAskedFor) {
  const auto plain = parse_simulated_uri("simulated:room");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->world, "room");
  EXPECT_EQ(plain->camera, 0);
  EXPECT_FALSE(plain->marker);
  const auto full =
      parse_simulated_uri("simulated:empty-room?camera=3&seed=9&marker=on&control=/tmp/a b&projectors=air");
  ASSERT_TRUE(full);
  EXPECT_EQ(full->world, "empty-room");
  EXPECT_EQ(full->camera, 3);
  EXPECT_EQ(full->cameras, 4);  // at least so many shine
  EXPECT_EQ(full->seed, 9u);
  EXPECT_TRUE(full->marker);
  EXPECT_EQ(full->control, "/tmp/a b");
  EXPECT_EQ(full->projectors, "air");
}

TEST(SimulatedUri, ListsTheSimulatorsWorldsAndCameras) {
  EXPECT_THAT(kSimulatedWorlds, testing::ElementsAreArray(simulation::world_names()));
  EXPECT_EQ(kMostSimulatedCameras, simulation::kMostKinects);
}

TEST(SimulatedUri, SaysWhatCouldStandThere) {
  const auto sentence = [](const char* uri) { return parse_simulated_uri(uri).error().what; };
  EXPECT_THAT(sentence("simulated:moon"), testing::HasSubstr("empty-room"));
  EXPECT_THAT(sentence("simulated:room?camera=8"), testing::HasSubstr("0 to 7"));
  EXPECT_THAT(sentence("simulated:room?camera=-1"), testing::HasSubstr("0 to 7"));
  EXPECT_THAT(sentence("simulated:room?camera=1x"), testing::HasSubstr("camera=1x"));
  EXPECT_THAT(sentence("simulated:room?zoom=2"), testing::HasSubstr("marker=on"));
  EXPECT_THAT(sentence("simulated:room?camera"), testing::HasSubstr("camera=N"));
  EXPECT_THAT(sentence("desk.oni"), testing::HasSubstr("simulated:WORLD"));
}

}  // namespace
}  // namespace copresence::drivers
