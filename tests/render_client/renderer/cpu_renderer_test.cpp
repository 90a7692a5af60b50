// Tests views of the surface of one camera.

#include "render_client/renderer/cpu/cpu_renderer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/render_client/renderer/rendering.h"

namespace copresence::renderer {
namespace {

constexpr int kWidth = 640, kHeight = 360;

// Greatest distance of a shown point from the plane n.P = d.
double farthest_from_plane(const MergedView& view, const ViewPose& eye, const Eigen::Vector3d& n, double d) {
  double worst = 0;
  for_each_shown(view, [&](int x, int y) {
    worst = std::max(worst, std::abs(n.dot(shown_point(view, eye, x, y)) - d));
  });
  return worst;
}

TEST(CpuRenderer, ShowsATiltedPlaneWhereItIsFromAMovedEye) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.2, 1).normalized();
  Looking camera(kinect_model(), plane(n, 2));
  for (double degrees : {-25.0, 0.0, 20.0}) {
    const ViewPose eye = orbiting_eye(kWidth, kHeight, degrees, 2);
    const MergedView view = render({&camera}, eye);
    EXPECT_GT(count_shown(view), kWidth * kHeight / 4);
    // The depth image is accurate to 0.1 mm.
    EXPECT_LT(farthest_from_plane(view, eye, n, 2), 0.0002) << degrees;
  }
}

TEST(CpuRenderer, ShowsTheColorThatLiesOnThePoint) {
  Looking camera(kinect_model(), plane(Eigen::Vector3d(0.3, 0.2, 1).normalized(), 2));
  const ViewPose eye = orbiting_eye(kWidth, kHeight, 20, 2);
  const MergedView view = render({&camera}, eye);
  double worst = 0;
  for_each_shown(view, [&](int x, int y) {
    const Eigen::Vector2d pixel = project(camera.view.model, shown_point(view, eye, x, y));
    worst = std::max(worst, std::abs(view.color(x, y).r - (30 + pixel.x() * 200 / 640)));
    worst = std::max(worst, std::abs(view.color(x, y).g - (30 + pixel.y() * 200 / 480)));
    ASSERT_EQ(view.color(x, y).a, 255);
  });
  EXPECT_LT(worst, 1.6);  // the gradient is rounded twice
}

TEST(CpuRenderer, ShowsTheCamerasOwnImageFromTheCamerasOwnPlace) {
  Looking camera(kinect_model(), together({wall(3), sphere({0, 0, 2}, 0.5)}));
  ViewPose eye;
  eye.intrinsics = camera.view.model;
  const MergedView view = render({&camera}, eye);
  for (int y = 1; y < 479; ++y) {
    for (int x = 1; x < 639; ++x) {
      if (view.depth_m(x, y) == 0) continue;
      ASSERT_TRUE(near_color(view.color(x, y), gradient(x, y))) << x << ' ' << y;
    }
  }
  EXPECT_GT(count_shown(view), 640 * 480 * 0.97);  // everything but the edge of the sphere
}

TEST(CpuRenderer, LeavesDiscontinuitiesOpen) {
  // A board 40 cm wide at 1.5 m, in front of a wall at 3 m.
  const auto board = [](double x, double y) {
    return std::abs(x) < 0.13 && std::abs(y) < 0.13 ? std::optional(1.5) : std::nullopt;
  };
  Looking camera(kinect_model(), together({wall(3), board}));
  for (int block : {1, 16}) {
    for (double degrees : {-30.0, 0.0, 15.0}) {
      const ViewPose eye = orbiting_eye(kWidth, kHeight, degrees, 2);
      const MergedView view = render({&camera}, eye, block);
      int on_board = 0, on_wall = 0, between = 0;
      for_each_shown(view, [&](int x, int y) {
        const double z = shown_point(view, eye, x, y).z();
        ++(std::abs(z - 1.5) < 0.001 ? on_board : std::abs(z - 3) < 0.001 ? on_wall : between);
      });
      EXPECT_GT(on_board, 3000);
      EXPECT_GT(on_wall, 30000);
      EXPECT_EQ(between, 0) << degrees << ", blocks of " << block;
    }
  }
}

// Counts empty pixels between two shown ones in their row and two in their column, from several
// eyes.
int count_cracks(const CameraModel& model) {
  // A wall with knobs, as a Kinect measures it. Planar blocks of all sizes lie beside single
  // pixels.
  std::vector<Surface> parts = {plane(Eigen::Vector3d(0.2, 0.1, 1).normalized(), 2)};
  for (int i = -3; i <= 3; ++i) {
    for (int j = -2; j <= 2; ++j) {
      parts.push_back(sphere({i * 0.31, j * 0.33, 2.299 - i * 0.062 - j * 0.033}, 0.3));
    }
  }
  Looking camera(model, together(parts));
  measure_like_a_kinect(camera.frame, 0, 3);
  int cracks = 0;
  for (const auto& [degrees, closer] : {std::pair(0.0, 0.0), {-17.0, 0.3}, {7.0, 1.0}}) {
    ViewPose eye = orbiting_eye(960, 540, degrees, 2);
    eye.world_from_eye.translation += eye.world_from_eye.rotation * Eigen::Vector3d(0, 0, closer);
    const MergedView view = render({&camera}, eye);
    for (int y = 1; y < view.height - 1; ++y) {
      for (int x = 1; x < view.width - 1; ++x) {
        const auto shown = [&](int dx, int dy) { return view.depth_m(x + dx, y + dy) > 0; };
        cracks += !shown(0, 0) && shown(-1, 0) && shown(1, 0) && shown(0, -1) && shown(0, 1);
      }
    }
    EXPECT_GT(count_shown(view), 200000);
  }
  return cracks;
}

TEST(CpuRenderer, HasNoCracksWhereFineAndCoarseMeshMeet) {
  EXPECT_EQ(count_cracks(kinect_model()), 0);
}

TEST(CpuRenderer, HasNoCracksBehindADistortedLensEither) {
  CameraModel lens = kinect_model();
  lens.distortion = {-0.25, 0.08, 0.001, -0.001, 0, 0, 0, 0};
  EXPECT_EQ(count_cracks(lens), 0);
}

TEST(CpuRenderer, LooksTheSameCoarseAsFine) {
  Looking camera(kinect_model(), together({plane(Eigen::Vector3d(0.2, 0.5, 1).normalized(), 2.2),
                                           sphere({0.2, 0, 1.7}, 0.3), sphere({-0.5, 0.2, 1.5}, 0.1)}));
  const ViewPose eye = orbiting_eye(1280, 720, 15, 2);
  const MergedView fine = render({&camera}, eye, 1), coarse = render({&camera}, eye, 16);
  int in_both = 0, in_one = 0;
  double error = 0, worst = 0;
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const double a = fine.depth_m(x, y), b = coarse.depth_m(x, y);
      in_one += (a > 0) != (b > 0);
      if (!(a > 0 && b > 0) || std::abs(a - b) > 0.1) continue;  // an edge that is half a pixel off
      ++in_both;
      error += std::abs(fine.color(x, y).r - coarse.color(x, y).r);
      worst = std::max(worst, std::abs(a - b) / kKinectV1Noise.step_m(a));
    }
  }
  EXPECT_LT(in_one, 0.002 * in_both);
  EXPECT_LT(error / in_both, 0.2);  // of 255
  EXPECT_LT(worst, 4);              // steps, where a sphere curves away
}

TEST(CpuRenderer, ShowsAFlatSurfaceSmootherThanTheSensorMeasuresIt) {
  Looking camera(kinect_model(), wall(3));
  measure_like_a_kinect(camera.frame, 0, 5);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  const auto noise = [&](int block) {
    const MergedView view = render({&camera}, eye, block);
    double squares = 0;
    for_each_shown(view, [&](int x, int y) { squares += std::pow(view.depth_m(x, y) - 3, 2); });
    return std::sqrt(squares / count_shown(view));
  };
  EXPECT_LT(noise(16), 0.6 * noise(1));
}

TEST(CpuRenderer, UndoesTheLensesDistortion) {
  CameraModel lens = kinect_model();
  lens.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633, 0, 0, 0};  // TUM RGB-D benchmark, Freiburg 1
  const Eigen::Vector3d n = Eigen::Vector3d(-0.2, 0.3, 1).normalized();
  Looking camera(lens, plane(n, 2));
  const ViewPose eye = orbiting_eye(kWidth, kHeight, 10, 2);
  const MergedView view = render({&camera}, eye);
  EXPECT_LT(farthest_from_plane(view, eye, n, 2), 0.0004);
  double worst = 0;
  for_each_shown(view, [&](int x, int y) {
    const Eigen::Vector2d pixel = project(lens, shown_point(view, eye, x, y));
    worst = std::max(worst, std::abs(view.color(x, y).r - (30 + pixel.x() * 200 / 640)));
  });
  EXPECT_LT(worst, 1.8);
}

TEST(CpuRenderer, FollowsALensOffItsAxis) {
  // The right half of a wide view, rendered as a separate picture.
  Looking camera(kinect_model(), together({wall(3), sphere({0, 0, 2}, 0.5)}));
  const ViewPose wide = orbiting_eye(kWidth, kHeight, 10, 2);
  ViewPose right = wide;
  right.intrinsics.width = kWidth / 2;
  right.intrinsics.cx -= kWidth / 2;
  const MergedView whole = render({&camera}, wide), half = render({&camera}, right);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      ASSERT_NEAR(half.depth_m(x, y), whole.depth_m(x + kWidth / 2, y), 1e-4) << x << ' ' << y;
    }
  }
}

TEST(CpuRenderer, ShowsNothingNearerOrFartherThanTheEyeSees) {
  Looking camera(kinect_model(),
                 plane(Eigen::Vector3d(0, -1, 0.25).normalized(), 0.5));  // a slope, 0.8 m to 6 m
  ViewPose eye = eye_at_origin(kWidth, kHeight);
  eye.near_m = 1.5;
  eye.far_m = 2.5;
  const MergedView view = render({&camera}, eye);
  float nearest = 10, farthest = 0;
  for_each_shown(view, [&](int x, int y) {
    nearest = std::min(nearest, view.depth_m(x, y));
    farthest = std::max(farthest, view.depth_m(x, y));
  });
  // A row of the view is 11 mm of depth at 1.5 m and 31 mm at 2.5 m.
  EXPECT_NEAR(nearest, 1.5, 0.012);
  EXPECT_GE(nearest, 1.5F - 1e-4F);
  EXPECT_NEAR(farthest, 2.5, 0.032);
  EXPECT_LE(farthest, 2.5F);
}

TEST(CpuRenderer, CutsASurfaceThatReachesBehindTheEye) {
  // A wall along the line of sight, on the right.
  const Eigen::Vector3d n = Eigen::Vector3d(1, 0, -0.2).normalized();
  Looking camera(kinect_model(), plane(n, 0.5));
  ViewPose eye = eye_at_origin(kWidth, kHeight);
  eye.world_from_eye.translation.z() = 2;
  const MergedView view = render({&camera}, eye);
  EXPECT_GT(count_shown(view), 10000);
  EXPECT_LT(farthest_from_plane(view, eye, n, 0.5), 0.003);
}

TEST(CpuRenderer, SeesFromBehindTheCameraToo) {
  Looking camera(kinect_model(), wall(2));
  ViewPose eye = eye_at_origin(kWidth, kHeight);
  eye.world_from_eye.translation = {0.1, 0, -1};
  const MergedView view = render({&camera}, eye);
  EXPECT_GT(count_shown(view), 20000);
  EXPECT_LT(farthest_from_plane(view, eye, {0, 0, 1}, 2), 0.0002);
}

TEST(CpuRenderer, ShowsNoSurfaceFromItsBack) {
  Looking camera(kinect_model(), wall(2));
  ViewPose eye = eye_at_origin(kWidth, kHeight);
  eye.world_from_eye.translation.z() = 4;
  eye.world_from_eye.rotation = turned(180);
  EXPECT_EQ(count_shown(render({&camera}, eye)), 0);
}

TEST(CpuRenderer, ShowsBlackWhereThereIsNothing) {
  Looking blind(kinect_model(), [](double, double) { return std::nullopt; });
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  for (const std::vector<Looking*>& cameras : {std::vector<Looking*>{}, {&blind}, {&blind, &blind}}) {
    const MergedView view = render(cameras, eye);
    ASSERT_EQ(view.width, kWidth);
    EXPECT_EQ(view.color, Image<Rgba8>(kWidth, kHeight, Rgba8{0, 0, 0, 0}));
    EXPECT_EQ(view.depth_m, Image<float>(kWidth, kHeight, 0.0F));
    EXPECT_EQ(view.camera, Image<std::uint8_t>(kWidth, kHeight, kNoCamera));
    EXPECT_EQ(view.quality, Image<float>(kWidth, kHeight, 0.0F));
  }
}

TEST(CpuRenderer, TakesFramesAndViewsOfAnySize) {
  for (const auto& [width, height] : {std::pair(2, 2), {18, 4}, {34, 50}, {320, 240}, {646, 486}}) {
    CameraModel model = {width, height, 0.9 * width, 0.9 * width, width / 2.0, height / 2.0, {}};
    Looking camera(model, wall(2));
    for (const auto& [view_width, view_height] : {std::pair(2, 2), {13, 35}, {321, 201}}) {
      const ViewPose eye = eye_at_origin(view_width, view_height);
      const MergedView view = render({&camera}, eye);
      EXPECT_EQ(view.color.width(), view_width);
      EXPECT_LT(farthest_from_plane(view, eye, {0, 0, 1}, 2), 0.0002);
      if (view_width > 2) {
        EXPECT_GT(count_shown(view), 0)
            << width << 'x' << height << " in " << view_width << 'x' << view_height;
      }
    }
  }
}

TEST(CpuRenderer, ShowsAsManyCamerasAsItPromises) {
  const CameraModel model = {16, 12, 16, 16, 8, 6, {}};
  std::vector<Looking> cameras;
  for (std::size_t i = 0; i < kMostCameras; ++i)
    cameras.emplace_back(model, wall(2), plain({0, 0, static_cast<std::uint8_t>(8 * i)}),
                         Rigid3{Eigen::Matrix3d::Identity(), {3.0 * static_cast<double>(i), 0, 0}});
  std::vector<Looking*> all;
  for (Looking& camera : cameras) all.push_back(&camera);
  ViewPose eye = eye_at_origin(32, 24);
  eye.world_from_eye = cameras.back().view.world_from_camera;
  const MergedView view = render(all, eye);
  EXPECT_EQ(view.camera(16, 12), kMostCameras - 1);
  EXPECT_TRUE(near_color(view.color(16, 12), {0, 0, 248}));
}

// If the principal points differed by half a pixel, the picture would be gray.
TEST(CpuRenderer, AViewFromANominalCamerasPoseIsThatCamerasPicture) {
  constexpr double kVerticalDegrees = 44.6;
  const CameraModel model = camera_from_field_of_view(160, 120, kVerticalDegrees * std::numbers::pi / 180);
  const auto checkers = [](int u, int v) {
    const auto shade = static_cast<std::uint8_t>((u + v) % 2 ? 250 : 5);
    return Rgb8{shade, shade, shade};
  };
  Looking camera(model, wall(2), Paint(checkers));
  ViewPose eye = eye_at_origin(160, 120);
  eye.world_from_eye = Rigid3{};
  eye.intrinsics = camera_from_field_of_view(160, 120, kVerticalDegrees * std::numbers::pi / 180);
  const MergedView view = render({&camera}, eye);
  for (int y = 1; y < 119; ++y) {
    for (int x = 1; x < 159; ++x)
      ASSERT_TRUE(near_color(view.color(x, y), checkers(x, y), 8)) << x << ' ' << y;
  }
}

TEST(CpuRenderer, ShadesACameraWithoutColorByItsTilt) {
  const auto gray_of_wall_tilted_by = [](double degrees) {
    Looking camera(kinect_model(),
                   plane(turned(degrees) * Eigen::Vector3d::UnitZ(), 2 * std::cos(degrees / 57.3)),
                   std::nullopt);
    const MergedView view = render({&camera}, eye_at_origin(kWidth, kHeight));
    const Rgba8 color = view.color(kWidth / 2, kHeight / 2);
    EXPECT_EQ(color.r, color.g);
    EXPECT_EQ(color.r, color.b);
    return color.r;
  };
  EXPECT_NEAR(gray_of_wall_tilted_by(0), 255, 1);
  EXPECT_NEAR(gray_of_wall_tilted_by(60), 255 * (0.15 + 0.85 * 0.5), 2);
}

TEST(CpuRenderer, AppliesTheColorCorrector) {
  Looking camera(kinect_model(), wall(2), plain({100, 50, 200}));
  camera.view.color_correction << 0, 1, 0, 0,  //
      0.5F, 0, 0, 0.1F,                        //
      0, 0, 2, 0;
  const MergedView view = render({&camera}, eye_at_origin(kWidth, kHeight));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), {50, 76, 255}));
}

TEST(CpuRenderer, KeepsWhatItDerivedUntilTheVersionChanges) {
  Looking camera(kinect_model(), wall(2));
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  MergedView view;
  const auto depth = [&] {
    EXPECT_TRUE(renderer->render(views_of({&camera}), eye, {.color = false, .depth = true}, view));
    return view.depth_m(kWidth / 2, kHeight / 2);
  };
  EXPECT_NEAR(depth(), 2, 1e-3);
  camera.frame = frame_of(camera.view.model, wall(3), std::nullopt);
  EXPECT_NEAR(depth(), 2, 1e-3);
  ++camera.view.version;
  EXPECT_NEAR(depth(), 3, 1e-3);
  EXPECT_TRUE(view.color.empty());
}

TEST(CpuRenderer, DrawsWhatItPreparedWithoutLookingAtTheFrameAgain) {
  Looking camera(kinect_model(), wall(2));
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  renderer->prepare(views_of({&camera}));
  camera.frame = frame_of(camera.view.model, wall(3), std::nullopt);
  MergedView view;
  ASSERT_TRUE(renderer->render(views_of({&camera}), eye_at_origin(kWidth, kHeight),
                               {.color = true, .depth = true}, view));
  EXPECT_NEAR(view.depth_m(kWidth / 2, kHeight / 2), 2, 1e-3);
}

TEST(CpuRenderer, TakesNewerFramesAndOtherCamerasThanItPrepared) {
  Looking left(kinect_model(), wall(2)), right(kinect_model(), wall(2));
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  renderer->prepare(views_of({&left, &right}));
  left.frame = frame_of(left.view.model, wall(3), Paint(gradient));
  ++left.view.version;
  MergedView view;
  ASSERT_TRUE(renderer->render(views_of({&left}), eye, {.color = true, .depth = true}, view));
  EXPECT_EQ(view.color, render({&left}, eye).color);
  EXPECT_NEAR(view.depth_m(kWidth / 2, kHeight / 2), 3, 1e-3);
}

}  // namespace
}  // namespace copresence::renderer
