#include "common/frame/camera_model.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/frame/depth_unit.h"

namespace copresence {
namespace {

CameraModel kinect() {
  return {640, 480, 585, 585, 320, 240, {}};
}

CameraModel distorted_kinect() {
  CameraModel camera = kinect();
  camera.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633, 0, 0, 0};  // TUM RGB-D benchmark, Freiburg 1
  return camera;
}

TEST(CameraModel, SeesAPointOnTheAxisAtThePrincipalPoint) {
  EXPECT_TRUE(project(kinect(), {0, 0, 2}).isApprox(Eigen::Vector2d(320, 240)));
}

TEST(CameraModel, PutsXToTheRightAndYDown) {
  const Eigen::Vector2d pixel = project(kinect(), {0.1, 0.2, 1});
  EXPECT_DOUBLE_EQ(pixel.x(), 320 + 58.5);
  EXPECT_DOUBLE_EQ(pixel.y(), 240 + 117);
}

TEST(CameraModel, UnprojectUndoesProjectAlsoWithDistortion) {
  for (const CameraModel& camera : {kinect(), distorted_kinect()}) {
    for (double x : {-0.5, 0.0, 0.3}) {
      for (double y : {-0.35, 0.1, 0.35}) {
        const Eigen::Vector3d point = Eigen::Vector3d(x, y, 1) * 2.5;
        EXPECT_TRUE(unproject(camera, project(camera, point), 2.5).isApprox(point, 1e-6)) << x << ' ' << y;
      }
    }
  }
}

TEST(CameraModel, RaysAreUnprojectedPixels) {
  const CameraModel camera = distorted_kinect();
  const auto all = rays(camera);
  ASSERT_EQ(all.size(), 640u * 480u);
  const Eigen::Vector3d point = unproject(camera, {17, 401}, 1.0);
  EXPECT_NEAR(all[401 * 640 + 17].x(), point.x(), 1e-6);
  EXPECT_NEAR(all[401 * 640 + 17].y(), point.y(), 1e-6);
}

TEST(CameraModel, FieldOfViewGivesTheFocalLength) {
  const CameraModel camera = camera_from_field_of_view(640, 480, 1.0, 0.8);
  EXPECT_NEAR(project(camera, {std::tan(0.5), 0, 1}).x(), 640, 1e-9);
  EXPECT_NEAR(project(camera, {0, std::tan(0.4), 1}).y(), 480, 1e-9);
}

TEST(CameraModel, RefusesSizesAndNumbersThatCannotBe) {
  EXPECT_TRUE(check(kinect()));
  for (auto spoil : std::initializer_list<void (*)(CameraModel&)>{
           [](CameraModel& c) { c.width = 639; }, [](CameraModel& c) { c.height = 0; },
           [](CameraModel& c) { c.width = 8192; }, [](CameraModel& c) { c.fx = 0; },
           [](CameraModel& c) { c.fy = -1; },
           [](CameraModel& c) { c.cx = std::numeric_limits<double>::quiet_NaN(); },
           [](CameraModel& c) { c.distortion[3] = std::numeric_limits<double>::infinity(); }}) {
    CameraModel camera = kinect();
    spoil(camera);
    const auto checked = check(camera);
    ASSERT_FALSE(checked);
    EXPECT_FALSE(checked.error().what.empty());
  }
}

TEST(CameraModel, RefusesADistortionThatFoldsThePictureOrTearsIt) {
  EXPECT_TRUE(check(distorted_kinect()));
  CameraModel camera = kinect();
  camera.distortion = {-9, 50, 0, 0, 0, 0, 0, 0};
  EXPECT_FALSE(check(camera));
  camera.distortion = {-0.2, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_TRUE(check(camera));
  camera.distortion[0] = -0.8;  // turns around before the corners
  EXPECT_FALSE(check(camera));
  // Fitted to a board's corners to 0.11 px by OpenCV: above and below a fraction's line are zeros, close together.
  camera = {640, 480, 584.115, 584.185, 320.512, 239.28, {}};
  camera.distortion = {-6.459571043904878, 8.002977728422218, -5.3003932919357835e-05, 0.0004995218441833445,
                       8.16036975966137,   -6.45702892311589, 7.984941682116481,       8.192284966704637};
  EXPECT_FALSE(check(camera));
}

TEST(DepthUnit, TurnsARangeInMetresIntoUnits) {
  EXPECT_EQ(to_units({0.4, 5.0}, DepthUnit::kMillimetre).near, 400);
  EXPECT_EQ(to_units({0.4, 5.0}, DepthUnit::k100Micrometres).far, 50000);
  EXPECT_EQ(to_units({0.4, 9.0}, DepthUnit::k100Micrometres).far, 65535);
}

TEST(DepthUnit, KnowsAKinectsStepAtOneAndFourMetres) {
  EXPECT_NEAR(sensor_step_m(1.0), 0.00285, 1e-5);
  EXPECT_NEAR(sensor_step_m(4.0), 0.0455, 1e-4);
}

}  // namespace
}  // namespace copresence
