#include "render_client/viewpoint/viewer.h"

#include <gtest/gtest.h>

#include <numbers>

namespace copresence::viewpoint {
namespace {

using Kind = ViewChoice::Kind;

constexpr ViewFormat kFormat{640, 480, 50};
const CameraModel kCamera = nominal_kinect(640, 480);

Rigid3 at(double x_m) {
  Rigid3 pose;
  pose.translation.x() = x_m;
  return pose;
}

Viewer mouse_viewer() {
  auto viewer = Viewer::open(*parse_view("mouse"), kFormat, {0, -1, 0});
  EXPECT_TRUE(viewer.has_value());
  return std::move(*viewer);
}

Rigid3 pose_of(Viewer& viewer) {
  const Eye middle;
  return viewer.at(0, {}, std::span(&middle, 1)).front().world_from_eye;
}

TEST(Viewer, BeginsAtTheFirstListedCameraThatIsThere) {
  Viewer viewer = mouse_viewer();
  viewer.on_camera_pose(2, at(2), kCamera);
  EXPECT_EQ(pose_of(viewer), at(2));
  viewer.on_camera_pose(0, at(5), kCamera);
  EXPECT_EQ(pose_of(viewer), at(5)) << "nobody has moved it, so it goes to the camera that is listed first";
  viewer.on_camera_pose(1, at(7), kCamera);
  EXPECT_EQ(pose_of(viewer), at(5));
}

TEST(Viewer, StaysWhereThePersonMovedItWhenAnEarlierListedCameraAppears) {
  Viewer viewer = mouse_viewer();
  viewer.on_camera_pose(1, at(2), kCamera);
  viewer.apply(Orbit{0.25, 0});
  const Rigid3 moved = pose_of(viewer);
  ASSERT_FALSE(moved == at(2));
  viewer.on_camera_pose(0, at(5), kCamera);
  EXPECT_EQ(pose_of(viewer), moved);
  viewer.apply(ResetPose{});
  EXPECT_EQ(pose_of(viewer), at(5)) << "the pose of the first listed camera";
}

TEST(Viewer, GoesToTheFirstCameraEvenIfThePointerWasDraggedOverTheEmptyView) {
  Viewer viewer = mouse_viewer();
  viewer.apply(Orbit{0.25, 0});
  viewer.on_camera_pose(0, at(5), kCamera);
  EXPECT_EQ(pose_of(viewer), at(5));
}

TEST(Viewer, GivesEveryEyeOfADisplayAPose) {
  Viewer viewer = mouse_viewer();
  viewer.on_camera_pose(0, at(5), kCamera);
  const std::vector<Eye> eyes{{.head_from_eye = at(-0.03)}, {.head_from_eye = at(0.03)}};
  const auto poses = viewer.at(0, {}, eyes);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_DOUBLE_EQ(poses[0].world_from_eye.translation.x(), 4.97);
  EXPECT_DOUBLE_EQ(poses[1].world_from_eye.translation.x(), 5.03);
  EXPECT_EQ(poses[0].intrinsics, camera_from_field_of_view(640, 480, 50 * std::numbers::pi / 180));
}

CameraModel intrinsics_of(const char* choice, const ViewFormat& format) {
  auto viewer = Viewer::open(choice ? *parse_view(choice) : ViewChoice{}, format, {0, -1, 0});
  EXPECT_TRUE(viewer.has_value());
  viewer->on_camera_pose(0, at(5), kCamera);
  const Eye middle;
  return viewer->at(0, {}, std::span(&middle, 1)).front().intrinsics;
}

TEST(Viewer, BeginsWithAPictureThatTheFirstCameraFills) {
  for (const char* const choice : {"mouse", static_cast<const char*>(nullptr)}) {
    const CameraModel view = intrinsics_of(choice, {1280, 720, {}});
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), Eigen::Vector2d(1279, 719)}) {
      const Eigen::Vector2d pixel = project(kCamera, unproject(view, corner, 1));
      EXPECT_GE(pixel.minCoeff(), -1e-9);
      EXPECT_LE(pixel.x(), kCamera.width - 1 + 1e-9);
      EXPECT_LE(pixel.y(), kCamera.height - 1 + 1e-9);
    }
    EXPECT_NEAR(project(kCamera, unproject(view, {0, 360}, 1)).x(), 0, 1) << "no narrower than needed";
  }
}

TEST(Viewer, KeepsTheFieldOfViewThatWasAskedFor) {
  EXPECT_EQ(intrinsics_of("mouse", {1280, 720, 50}),
            camera_from_field_of_view(1280, 720, 50 * std::numbers::pi / 180));
}

TEST(ParseView, TakesWhatTheHelpSays) {
  EXPECT_EQ(parse_view("mouse")->kind, Kind::kMouse);
  EXPECT_EQ(parse_view("path:a b")->path_file, "a b");
  EXPECT_EQ(parse_view("opentrack")->tracker_port, 4242);
  EXPECT_EQ(parse_view("opentrack:65535")->tracker_port, 65535);
  for (const char* text : {"", "Mouse", "path", "path:", "opentrack:", "opentrack:0", "opentrack:65536",
                           "opentrack:-1", "opentrack:1x", "opentrack4242", "fixed"}) {
    EXPECT_FALSE(parse_view(text)) << text;
  }
}

}  // namespace
}  // namespace copresence::viewpoint
