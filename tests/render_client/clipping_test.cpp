#include "render_client/clipping.h"

#include <gtest/gtest.h>

namespace copresence::client {
namespace {

RgbdFrame wall(int width, int height, std::uint16_t depth_mm) {
  RgbdFrame frame;
  frame.depth = DepthImage(width, height, depth_mm);
  frame.state = StateImage(width, height, DepthState::kMeasured);
  return frame;
}

const CameraModel kCamera{8, 6, 8, 8, 4, 3, {}};

TEST(Clipping, KeepsWhatLiesInTheBox) {
  RgbdFrame frame = wall(8, 6, 2000);
  clip(frame, kCamera, DepthUnit::kMillimetre, Rigid3{}, {{-5, -5, 1}, {5, 5, 3}});
  EXPECT_EQ(frame.depth, DepthImage(8, 6, 2000));
}

TEST(Clipping, MakesHolesOfTheRestInTheWorldsFrame) {
  RgbdFrame frame = wall(8, 6, 2000);
  Rigid3 world_from_camera;
  world_from_camera.translation.x() = 10;
  clip(frame, kCamera, DepthUnit::kMillimetre, world_from_camera, {{10, -5, 1}, {20, 5, 3}});
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(frame.depth(x, y), x < 4 ? 0 : 2000) << x;
      EXPECT_EQ(frame.state(x, y), x < 4 ? DepthState::kHole : DepthState::kMeasured);
    }
  }
}

}  // namespace
}  // namespace copresence::client
