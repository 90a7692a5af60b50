#include "render_client/camera_setup/camera_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render_client/color_matching/live_color_matching.h"
#include "render_client/shown_cameras.h"

namespace copresence::client {
namespace {

using ::testing::HasSubstr;

StreamDescription stream_of(const std::string& camera) {
  StreamDescription stream;
  stream.camera = camera;
  stream.model = {640, 480, 585, 585, 320, 240, {}};
  return stream;
}

scene::Scene scene_with(const CameraModel& model) {
  scene::Scene scene;
  scene::Camera& camera = scene.cameras.emplace_back();
  camera.name = "left";
  camera.model = model;
  return scene;
}

TEST(CameraSetup, IsTheStreamsWithoutASceneFile) {
  StreamDescription stream = stream_of("left");
  const CameraSetup setup = resolve_setup(stream, nullptr);
  EXPECT_EQ(setup.model, stream.model);
  EXPECT_FALSE(setup.has_pose);
  EXPECT_TRUE(setup.remark.empty());
  stream.has_pose = true;
  EXPECT_TRUE(resolve_setup(stream, nullptr).has_pose);
}

TEST(CameraSetup, IsTheStreamsForACameraThatTheSceneFileDoesNotName) {
  const scene::Scene scene = scene_with({640, 480, 500, 500, 310, 250, {}});
  EXPECT_EQ(resolve_setup(stream_of("right"), &scene).model, stream_of("right").model);
}

TEST(CameraSetup, TakesWhatTheSceneFileSays) {
  scene::Scene scene = scene_with({640, 480, 500, 500, 310, 250, {}});
  scene::Camera& camera = scene.cameras.front();
  camera.world_from_camera.emplace().translation.x() = 2;
  camera.color_matching = color_matching::ColorCorrection::Identity() * 0.5F;
  camera.calibration_error_mm = 12;
  CameraFrame frame;
  frame.frame.metadata.world_from_camera.translation.x() = 7;
  frame.setup = std::make_shared<const CameraSetup>(resolve_setup(stream_of("left"), &scene));
  EXPECT_EQ(frame.setup->model, camera.model);
  EXPECT_TRUE(frame.setup->has_pose);

  const renderer::CameraView view = camera_view(frame, 3, color_matching::ColorCorrection::Identity());
  EXPECT_EQ(view.frame, &frame.frame);
  EXPECT_EQ(view.version, 3U);
  EXPECT_EQ(view.model, camera.model);
  EXPECT_EQ(view.world_from_camera.translation.x(), 2);
  EXPECT_EQ(view.color_correction, *camera.color_matching);
  EXPECT_DOUBLE_EQ(view.calibration_error_m, 0.012);

  const color_matching::PosedFrame posed = color_matching::posed_frame(frame);
  EXPECT_EQ(posed.model, view.model);
  EXPECT_EQ(posed.world_from_camera, view.world_from_camera);
  EXPECT_EQ(posed.calibration_error_m, view.calibration_error_m);
}

TEST(CameraSetup, LeavesOutIntrinsicsOfAnotherSizeAndSaysSo) {
  const scene::Scene scene = scene_with({1280, 960, 1170, 1170, 640, 480, {}});
  const CameraSetup setup = resolve_setup(stream_of("left"), &scene);
  EXPECT_EQ(setup.model, stream_of("left").model);
  EXPECT_THAT(setup.remark, HasSubstr("left"));
  EXPECT_THAT(setup.remark, HasSubstr("1280x960"));
  EXPECT_THAT(setup.remark, HasSubstr("640x480"));
}

}  // namespace
}  // namespace copresence::client
