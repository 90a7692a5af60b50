#include "simulation/truth/true_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

std::shared_ptr<const LitScene> world_with_person() {
  Scene scene = wall_at(3);
  scene.figure = make_person(scene);
  scene.figure.world_from_figure.translation() = Eigen::Vector3f(0, 0.9f, 2);
  return std::make_shared<const LitScene>(LitScene::make(std::move(scene)).value());
}

TEST(TrueCamera, MeasuresAPlaneExactly) {
  const TrueView view = view_of(world_of(wall_at(2)), small_kinect());
  for (const float z : view.depth_m.pixels()) ASSERT_NEAR(z, 2, 1e-5);
}

TEST(TrueCamera, MeasuresASlantedPlaneAlongTheOpticalAxis) {
  // The camera turned by 30 degrees about y: z' = 2 / (cos 30 + x' sin 30) on the ray (x', y', 1).
  const double angle = M_PI / 6;
  const TrueView view = view_of(world_of(wall_at(2)), small_kinect(),
                                look_from({0, 0, 0}, {-std::sin(angle), 0, std::cos(angle)}));
  const CameraModel model = small_kinect();
  for (int x = 0; x < model.width; x += 7) {
    const double ray_x = (x - model.cx) / model.fx;
    EXPECT_NEAR(view.depth_m(x, 100), 2 / (std::cos(angle) + ray_x * std::sin(angle)), 1e-4);
  }
}

TEST(TrueCamera, SaysWhereNothingIs) {
  const TrueView view = view_of(world_of(wall_at(2)), small_kinect(), look_from({0, 0, 0}, {0, 0, -1}));
  for (const float z : view.depth_m.pixels()) ASSERT_EQ(z, 0);
}

TEST(TrueCamera, SeesLensesDistort) {
  CameraModel model = small_kinect();
  model.distortion = {0.2, -0.4, 0.001, 0.002, 0.1, 0, 0, 0};
  Scene scene = wall_at(3);
  scene.add(panel({0, 0, 2}, {0.4f, 0, 0}, {0, 0.3f, 0}, 0, 10));
  const TrueView view = view_of(world_of(std::move(scene)), model);
  const Eigen::Vector2d corner = project(model, {0.4, 0.3, 2});
  const int x = static_cast<int>(std::lround(corner.x())), y = static_cast<int>(std::lround(corner.y()));
  EXPECT_NEAR(view.depth_m(x - 2, y - 2), 2, 1e-4);
  EXPECT_NEAR(view.depth_m(x + 2, y + 2), 3, 1e-4);
}

TEST(TrueCamera, TwoViewpointsShowOneScene) {
  const auto world = world_with_person();
  const CameraModel model = small_kinect();
  auto left = TrueCamera::make(world, model, look_from({-0.5, 0, 0.1}, {0, 0, 2})).value();
  auto right = TrueCamera::make(world, model, look_from({0.5, -0.1, 0}, {0, 0, 2})).value();
  const TrueView &a = left.trace(0.3), &b = right.trace(0.3);
  const Rigid3 right_from_left = right.world_from_camera().inverse() * left.world_from_camera();
  int same = 0, hidden = 0, wrong = 0, color_apart = 0;
  for (int y = 0; y < model.height; ++y) {
    for (int x = 0; x < model.width; ++x) {
      const Eigen::Vector3d point =
          right_from_left * unproject(model, {double(x), double(y)}, a.depth_m(x, y));
      const Eigen::Vector2d pixel = project(model, point);
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      if (u < 0 || v < 0 || u >= model.width || v >= model.height) continue;
      const double there = b.depth_m(u, v);
      if (std::abs(there - point.z()) < 0.02) {
        ++same;
        color_apart += std::abs(int(a.color(x, y).g) - int(b.color(u, v).g)) > 40;
      } else if (there < point.z()) {
        ++hidden;
      } else {
        ++wrong;  // b looks through what a sees: only at outlines, by rounding to whole pixels
      }
    }
  }
  EXPECT_GT(same, 40000);
  EXPECT_GT(hidden, 500);
  EXPECT_LT(wrong, same / 50);
  EXPECT_LT(color_apart, same / 50);
}

TEST(TrueCamera, ClosesItsMotionWithoutASeam) {
  auto camera = TrueCamera::make(world_with_person(), small_kinect(), {}).value();
  const TrueView first = camera.trace(phase_of_frame(0, 60));
  const TrueView half = camera.trace(phase_of_frame(30, 60));
  const TrueView again = camera.trace(phase_of_frame(60, 60));
  EXPECT_NE(first.depth_m, half.depth_m);
  EXPECT_EQ(first.depth_m, again.depth_m);
  EXPECT_EQ(first.color, again.color);
  EXPECT_EQ(first.infrared, again.infrared);
}

TEST(TrueCamera, ForgetsWhereTheFigureWas) {
  // The same look after different pasts.
  auto camera = TrueCamera::make(world_with_person(), small_kinect(), {}).value();
  auto fresh = TrueCamera::make(world_with_person(), small_kinect(), {}).value();
  for (const double phase : {0.9, 0.1, 0.6}) camera.trace(phase);
  const TrueView &used = camera.trace(0.25), &clean = fresh.trace(0.25);
  EXPECT_EQ(used.depth_m, clean.depth_m);
  EXPECT_EQ(used.color, clean.color);
}

TEST(TrueCamera, FindsAllOfTheFigure) {
  // The camera traces only some cells of pixels. Every pixel must be as if all of them were traced.
  const auto world = world_with_person();
  auto camera = TrueCamera::make(world, small_kinect(), {}).value();
  PosedScene whole(world->figure_parts());
  for (const double phase : {0.0, 0.37, 0.71}) {
    const TrueView& view = camera.trace(phase);
    whole.pose(world->figure().pose(phase));
    const auto eye_rays = rays(small_kinect());
    std::vector<Ray> traced;
    for (const auto& ray : eye_rays) traced.push_back(Ray{{0, 0, 0}, {ray.x(), ray.y(), 1}});
    whole.trace(traced);
    for (std::size_t i = 0; i < traced.size(); ++i) {
      const float expected = traced[i].mesh >= 0 ? traced[i].far : camera.background().depth_m.data()[i];
      ASSERT_NEAR(view.depth_m.data()[i], expected, 1e-5) << i % 320 << ' ' << i / 320;
    }
  }
}

TEST(TrueCamera, ShowsASheetFromBothSides) {
  Scene scene = wall_at(3);
  const int paper = scene.add(Material{});
  Figure& sheet = scene.figure;
  sheet.parts.push_back(panel({0, 0, 0}, {0.3f, 0, 0}, {0, 0.2f, 0}, paper, 0.1f));
  sheet.capsules.push_back({{0, 0, 0}, {0, 0.01f, 0}, 0.01f});
  sheet.motion = [](double phase) {
    Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
    pose.translate(Eigen::Vector3f(0, 0, 2));
    pose.rotate(Eigen::AngleAxisf(static_cast<float>(2 * M_PI * phase), Eigen::Vector3f::UnitY()));
    return std::vector{pose};
  };
  auto camera = TrueCamera::make(std::make_shared<const LitScene>(LitScene::make(std::move(scene)).value()),
                                 small_kinect(), {})
                    .value();
  for (const double phase : {0.0, 0.5}) {
    const TrueView& view = camera.trace(phase);
    EXPECT_NEAR(view.depth_m(160, 120), 2, 1e-3) << phase;
    EXPECT_NEAR(view.depth_m(160 + 40, 120), 2, 1e-3) << phase;
    EXPECT_NEAR(view.depth_m(160 + 48, 120), 3, 1e-3) << phase;  // the sheet ends 44 pixels from its centre
  }
}

TEST(TrueCamera, RefusesWhatCannotBe) {
  const auto world = world_of(wall_at(2));
  CameraModel odd = small_kinect();
  odd.width = 321;
  EXPECT_FALSE(TrueCamera::make(world, odd, {}));
  EXPECT_FALSE(TrueCamera::make(world, small_kinect(),
                                Rigid3{2 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}));
}

}  // namespace
}  // namespace copresence::simulation
