#include "common/frame/nominal_camera.h"

#include <gtest/gtest.h>

namespace copresence {
namespace {

TEST(NominalKinect, HasSquarePixelsInEverySize) {
  for (const auto& [width, height] :
       {std::pair{640, 480}, std::pair{1280, 720}, std::pair{480, 640}, std::pair{1280, 1024}}) {
    const CameraModel camera = nominal_kinect(width, height);
    EXPECT_DOUBLE_EQ(camera.fx, camera.fy) << width;
    EXPECT_NEAR(camera.fx, 575.8 * std::max(width, height) / 640, 0.1) << width;
    EXPECT_EQ(camera.cx, width / 2.0);
    EXPECT_EQ(camera.cy, height / 2.0);
  }
}

TEST(CameraOfSensor, TakesAnglesThatFitAsTheyAre) {
  const CameraModel camera = camera_of_sensor(640, 480, 1.0, 0.8);
  EXPECT_EQ(camera, camera_from_field_of_view(640, 480, 1.0, 0.8));
}

TEST(CameraOfSensor, HasSquarePixelsWhereTheAnglesAreThoseOfAnotherMode) {
  const CameraModel wide = camera_of_sensor(1280, 720, 1.0144686, 0.7898090);
  EXPECT_DOUBLE_EQ(wide.fx, wide.fy);
  EXPECT_NEAR(wide.fx, 2 * 575.8, 0.1);
  const CameraModel tall = camera_of_sensor(480, 640, 1.0144686, 0.7898090);
  EXPECT_DOUBLE_EQ(tall.fx, tall.fy);
}

}  // namespace
}  // namespace copresence
