#include "render_client/decoding/frame_conditioning.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/executor.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/shown_cameras.h"

namespace copresence::decoding {
namespace {

RgbdFrame wall(int width, int height, std::uint16_t depth_mm) {
  RgbdFrame frame;
  frame.depth = DepthImage(width, height, depth_mm);
  frame.state = StateImage(width, height, DepthState::kMeasured);
  return frame;
}

client::CameraSetup small_camera() {
  client::CameraSetup setup;
  setup.model = {8, 6, 8, 8, 4, 3, {}};
  return setup;
}

TEST(Clipping, KeepsWhatLiesInTheBox) {
  RgbdFrame frame = wall(8, 6, 2000);
  Clipper(small_camera(), {{-5, -5, 1}, {5, 5, 3}}).apply(frame);
  EXPECT_EQ(frame.depth, DepthImage(8, 6, 2000));
}

TEST(Clipping, MakesHolesOfTheRestInTheWorldsFrame) {
  RgbdFrame frame = wall(8, 6, 2000);
  frame.metadata.world_from_camera.translation.x() = 10;
  Clipper(small_camera(), {{10, -5, 1}, {20, 5, 3}}).apply(frame);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(frame.depth(x, y), x < 4 ? 0 : 2000) << x;
      EXPECT_EQ(frame.state(x, y), x < 4 ? DepthState::kHole : DepthState::kMeasured);
    }
  }
}

TEST(Clipping, UsesThePoseOfTheSceneFileRatherThanTheFrames) {
  RgbdFrame frame = wall(8, 6, 2000);
  frame.metadata.world_from_camera.translation.x() = 10;
  client::CameraSetup setup = small_camera();
  setup.fixed_pose.emplace();
  Clipper(setup, {{-5, -5, 1}, {5, 5, 3}}).apply(frame);
  EXPECT_EQ(frame.depth, DepthImage(8, 6, 2000));
}

// Calibrated intrinsics differ from the nominal ones in the stream. Clipping must remove exactly
// what the view would show outside the box.
TEST(Clipping, AgreesWithRenderingWhereTheScenesIntrinsicsDifferFromTheStreams) {
  StreamDescription stream;
  stream.camera = "left";
  stream.model = {320, 240, 290, 290, 160, 120, {}};
  stream.unit = DepthUnit::kMillimetre;
  scene::Scene scene;
  scene::Camera& calibrated = scene.cameras.emplace_back();
  calibrated.name = "left";
  calibrated.model = {320, 240, 260, 262, 171, 113, {0.1, -0.2, 0, 0, 0, 0, 0, 0}};
  calibrated.world_from_camera.emplace();
  const scene::Box box{{-0.3, -0.2, 1}, {0.4, 0.3, 3}};

  const client::CameraSetup setup = client::resolve_setup(stream, &scene);
  client::CameraFrame clipped;
  clipped.frame = wall(320, 240, 2000);
  clipped.setup = std::make_shared<const client::CameraSetup>(setup);
  Clipper(setup, box).apply(clipped.frame);

  InlineExecutor workers;
  const auto renderer = renderer::make_cpu_renderer(workers);
  viewpoint::ViewPose eye;
  eye.intrinsics = camera_from_field_of_view(640, 480, 45 * std::numbers::pi / 180);
  const renderer::CameraView camera =
      client::camera_view(clipped, 1, color_matching::ColorCorrection::Identity());
  renderer::MergedView view;
  ASSERT_TRUE(renderer->render({&camera, 1}, eye, {.depth = true}, view));
  Eigen::Vector3d least(9, 9, 9), most(-9, -9, -9);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (view.depth_m(x, y) == 0) continue;
      const Eigen::Vector3d point = unproject(eye.intrinsics, {double(x), double(y)}, view.depth_m(x, y));
      least = least.cwiseMin(point);
      most = most.cwiseMax(point);
    }
  }
  // One pixel of the camera is 8 mm at 2 m. With the stream's intrinsics these edges would be off
  // by 40 to 150 mm.
  constexpr double kPixelM = 0.009;
  EXPECT_NEAR(least.x(), box.min.x(), kPixelM);
  EXPECT_NEAR(least.y(), box.min.y(), kPixelM);
  EXPECT_NEAR(most.x(), box.max.x(), kPixelM);
  EXPECT_NEAR(most.y(), box.max.y(), kPixelM);
}

}  // namespace
}  // namespace copresence::decoding
