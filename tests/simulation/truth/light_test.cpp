#include <gtest/gtest.h>

#include "simulation/truth/lit_scene.h"
#include "simulation/truth/shadow.h"
#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

TEST(LitScene, LightFallsOffWithDistanceAndStopsAtSolids) {
  Scene scene = wall_at(2);
  scene.lights = {{{0, 0, 0}, {0.01f, 0, 0}, {0, -0.01f, 0}, {4, 4, 4}}};  // faces +z
  scene.meshes.clear();
  scene.add(panel({0, 0, 2}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0, 0.1f));
  const auto open = LitScene::make(scene).value();
  EXPECT_NEAR(open.light().vertices[0][60].lamp.x(), 1, 0.02);  // 4 / 2^2 in the middle
  scene.add(panel({0, 0, 1}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0, 0.5f));
  const auto closed = LitScene::make(scene).value();
  EXPECT_EQ(closed.light().vertices[0][60].lamp.x(), 0);
}

TEST(Shadow, CapsulesShadeThePointsBehindThem) {
  ShadowPoints points;
  const Eigen::Vector3f lamp(0, -2, 0);
  points.add({0, 0, 0});
  points.add({0.5f, 0, 0});
  points.aim_at(lamp);
  std::vector<float> hidden(2);
  const Capsule bar{{-0.05f, -1, -1}, {-0.05f, -1, 1}, 0.1f};
  cast_shadows(points, {&bar, 1}, 0.02f, hidden);
  EXPECT_NEAR(hidden[0], 1, 1e-3);
  EXPECT_NEAR(hidden[1], 0, 1e-3);
}

}  // namespace
}  // namespace copresence::simulation
