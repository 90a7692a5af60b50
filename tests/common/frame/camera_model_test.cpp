#include "common/frame/camera_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

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

// Largest error of project(unproject()) over the picture, its rim and corners included; pixels.
double worst_round_trip(const CameraModel& camera) {
  double worst = 0;
  for (int j = 0; j <= 24; ++j) {
    for (int i = 0; i <= 32; ++i) {
      const Eigen::Vector2d pixel((camera.width - 1.0) * i / 32, (camera.height - 1.0) * j / 24);
      worst = std::max(worst, (project(camera, unproject(camera, pixel, 1)) - pixel).norm());
    }
  }
  return worst;
}

TEST(CameraModel, TakesWideLensesAndUnprojectsThemAllOverThePicture) {
  const std::vector<CameraModel> lenses{
      {1280, 960, 550, 550, 640, 480, {-0.28, 0.06, 0, 0, 0, 0, 0, 0}},
      {640, 480, 275, 275, 320, 240, {-0.28, 0.06, 0, 0, 0, 0, 0, 0}},
      {640, 480, 270, 272, 331, 228, {-0.3, 0.09, 0.001, -0.0015, -0.008, 0, 0, 0}},
      {1920, 1080, 1000, 1000, 960, 540, {-0.33, 0.12, 0, 0, -0.015, 0, 0, 0}},
      {320, 240, 200, 200, 160, 120, {0.9, 0.1, 0.0008, -0.0005, 0, 1.1, 0.2, 0.01}},
      // Azure Kinect's wide colour camera: large coefficients in numerator and denominator
      {1280, 720, 605, 605, 638, 366, {0.55, -2.5, 0.0007, -0.0001, 1.43, 0.43, -2.32, 1.36}},
      {640, 480, 500, 500, 320, 240, {0.9, 0.8, 0, 0, 0.4, 0, 0, 0}},  // a strong pincushion
  };
  for (const CameraModel& lens : lenses) {
    const auto checked = check(lens);
    EXPECT_TRUE(checked) << lens.fx << ": " << checked.error().what;
    EXPECT_LT(worst_round_trip(lens), 1e-6) << lens.fx;
  }
}

TEST(CameraModel, UnprojectsToTheRayOnThisSideOfAFold) {
  // r (1 - 0.28 r2 + 0.02 r4) decreases from r = 1.20 to r = 2.64 and then rises again, so three
  // rays lead to one pixel.
  CameraModel camera{640, 480, 400, 400, 320, 240, {-0.28, 0.02, 0, 0, 0, 0, 0, 0}};
  for (double r = 0.05; r < 1.17; r += 0.05) {
    const Eigen::Vector3d ray(0.8 * r, -0.6 * r, 1);
    EXPECT_TRUE(unproject(camera, project(camera, ray), 1).isApprox(ray, 1e-7)) << r;
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

// What OpenNI2's convertDepthToWorld() computes from the field of view alone, for any pixel.
TEST(CameraModel, FieldOfViewMeansWhatItMeansToOpenNi) {
  constexpr int kWidth = 640, kHeight = 480;
  constexpr double kHorizontal = 1.0144, kVertical = 0.7898;  // a Kinect's, as OpenNI2 gives them
  const CameraModel camera = camera_from_field_of_view(kWidth, kHeight, kHorizontal, kVertical);
  EXPECT_EQ(camera.cx, 320);
  EXPECT_EQ(camera.cy, 240);
  for (const auto& [column, row] : {std::pair{0, 0}, {320, 240}, {17, 401}, {639, 479}}) {
    const double z = 2.5;
    const double x = (double(column) / kWidth - 0.5) * z * 2 * std::tan(kHorizontal / 2);
    const double y =
        (double(row) / kHeight - 0.5) * z * 2 * std::tan(kVertical / 2);  // OpenNI's own y points up
    const Eigen::Vector3d point = unproject(camera, {double(column), double(row)}, z);
    EXPECT_NEAR(point.x(), x, 1e-12);
    EXPECT_NEAR(point.y(), y, 1e-12);
  }
}

TEST(CameraModel, SquarePixelsHaveOneFocalLength) {
  const CameraModel camera = camera_from_field_of_view(1280, 720, 0.9);
  EXPECT_EQ(camera.fx, camera.fy);
  EXPECT_NEAR(camera.fy, 360 / std::tan(0.45), 1e-9);
  EXPECT_EQ(camera.cx, 640);
  EXPECT_EQ(camera.cy, 360);
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
  camera.distortion[0] = -0.8;  // decreases before the corners
  EXPECT_FALSE(check(camera));
  // Fitted to a board's corners to 0.11 px by OpenCV: numerator and denominator have zeros close
  // together.
  camera = {640, 480, 584.115, 584.185, 320.512, 239.28, {}};
  camera.distortion = {-6.459571043904878, 8.002977728422218, -5.3003932919357835e-05, 0.0004995218441833445,
                       8.16036975966137,   -6.45702892311589, 7.984941682116481,       8.192284966704637};
  EXPECT_FALSE(check(camera));
}

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

TEST(DepthUnit, TurnsARangeInMetresIntoUnits) {
  EXPECT_EQ(to_units({0.4, 5.0}, DepthUnit::kMillimetre).near, 400);
  EXPECT_EQ(to_units({0.4, 5.0}, DepthUnit::k100Micrometres).far, 50000);
  EXPECT_EQ(to_units({0.4, 9.0}, DepthUnit::k100Micrometres).far, 65535);
}

TEST(DepthNoise, OfAKinectHasItsStepAtOneAndFourMetres) {
  EXPECT_NEAR(kKinectV1Noise.step_m(1.0), 0.00285, 1e-5);
  EXPECT_NEAR(kKinectV1Noise.step_m(4.0), 0.0455, 1e-4);
  EXPECT_EQ(kKinectV1Noise.sigma_m(4.0), 0.5 * kKinectV1Noise.step_m(4.0));
}

TEST(DepthNoise, StepsAreEvenInInverseDepth) {
  constexpr DepthNoise kNoise{.disparity_constant_m = 100, .sigma_steps = 2};
  EXPECT_NEAR(1 / 3.0 - 1 / (3.0 + kNoise.step_m(3.0)), kNoise.inverse_step(), 5e-4);
  EXPECT_EQ(kNoise.sigma_m(3.0), 2 * kNoise.step_m(3.0));
}

}  // namespace
}  // namespace copresence
