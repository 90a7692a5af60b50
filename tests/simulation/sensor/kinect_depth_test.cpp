#include "simulation/sensor/kinect_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

constexpr DepthUnit kMm = DepthUnit::kMillimetre;

DepthImage exposed(KinectNoise& noise, const TrueView& view, std::uint64_t frame) {
  const int width = view.depth_m.width(), height = view.depth_m.height();
  DotImage dots;
  project_dots(kinect_model(width, height), view, dots);
  DepthImage depth(width, height);
  noise.add_noise(dots, frame, depth.pixels());
  return depth;
}

DepthImage exposed(const TrueView& view, std::uint64_t frame = 0, std::uint32_t seed = 1,
                   std::uint32_t camera = 0, DepthUnit unit = kMm) {
  KinectNoise noise(kinect_model(view.depth_m.width(), view.depth_m.height()), unit, seed, camera);
  return exposed(noise, view, frame);
}

double hole_share(const DepthImage& depth) {
  return static_cast<double>(std::count(depth.pixels().begin(), depth.pixels().end(), 0)) /
         static_cast<double>(depth.pixels().size());
}

TrueView flat_view(const CameraModel& model, float z) {
  return {Image<float>(model.width, model.height, z), ColorImage(model.width, model.height),
          Image<float>(model.width, model.height, 0.8f)};
}

TEST(ProjectedDots, HaveTheDisparityOfAWallAndLessLightFarAway) {
  const CameraModel model = small_kinect();
  DotImage near, far;
  project_dots(model, flat_view(model, 1.0f), near);
  project_dots(model, flat_view(model, 3.0f), far);
  for (std::size_t i = 0; i < near.pixels().size(); ++i) {
    ASSERT_NEAR(near.data()[i].level, 351.3, 1e-3);
    ASSERT_NEAR(far.data()[i].level, 117.1, 1e-3);
    ASSERT_LT(far.data()[i].intensity, near.data()[i].intensity);
  }
}

TEST(ProjectedDots, AreMissingInTheShadowLeftOfANearSurface) {
  const CameraModel model = kinect_model(640, 480);
  const float near = 1.2f, far = 2.4f;
  TrueView view = flat_view(model, far);
  for (int y = 0; y < 240; ++y) {  // only the upper half has a near surface
    for (int x = 300; x < 400; ++x) view.depth_m(x, y) = near;
  }
  DotImage dots;
  project_dots(model, view, dots);
  const auto shadow = [&](int y, int from, int to) {
    int count = 0;
    for (int x = from; x < to; ++x) count += dots(x, y).level == 0;
    return count;
  };
  for (int y = 0; y < 240; ++y) {
    ASSERT_EQ(shadow(y, 0, 640), shadow(y, 280, 300)) << y;  // the whole shadow is at the left edge
    ASSERT_NEAR(shadow(y, 280, 300), shadow_width_px(model.fx, near, far), 1) << y;
  }
  for (int y = 240; y < 480; ++y) ASSERT_EQ(shadow(y, 0, 640), 0) << y;
}

TEST(KinectNoise, HasTheLevelsOfAKinectFromHalfAMetreToFive) {
  const auto levels = kinect_levels(DepthUnit::k100Micrometres);
  EXPECT_EQ(levels.size(), 632u);
  EXPECT_GE(levels.front(), 5000);
  EXPECT_LE(levels.back(), 50000);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const double z = (levels[i] + levels[i - 1]) * 0.5e-4;
    EXPECT_NEAR((levels[i] - levels[i - 1]) * 1e-4, kKinectV1Noise.step_m(z), 1.1e-4) << z;
  }
}

TEST(KinectNoise, GivesOnlyGenuineLevels) {
  for (const DepthUnit unit : {kMm, DepthUnit::k100Micrometres}) {
    const auto levels = kinect_levels(unit);
    const DepthImage depth = exposed(
        view_of(world_of(wall_at(2.0f)), small_kinect(), look_from({0, 0, 0}, {1, 0.3, 1.2})), 3, 1, 0, unit);
    for (const std::uint16_t value : depth.pixels()) {
      ASSERT_TRUE(value == 0 || std::binary_search(levels.begin(), levels.end(), value)) << value;
    }
    EXPECT_LT(hole_share(depth), 0.5);
  }
}

TEST(KinectNoise, ErrsByHalfALevelAndNotToOneSide) {
  for (const float z : {0.8f, 1.5f, 3.0f, 4.5f}) {
    const DepthImage depth =
        exposed(view_of(world_of(wall_at(z)), small_kinect()), 0, 7, 0, DepthUnit::k100Micrometres);
    double sum = 0, squares = 0, count = 0;
    for (const std::uint16_t value : depth.pixels()) {
      if (value == 0) continue;
      const double error = (value * 1e-4 - z) / kKinectV1Noise.step_m(z);
      sum += error;
      squares += error * error;
      ++count;
    }
    ASSERT_GT(count, 0.9 * static_cast<double>(depth.pixels().size()));
    EXPECT_NEAR(sum / count, 0, 0.25) << z;
    EXPECT_NEAR(std::sqrt(squares / count), 0.5, 0.15) << z;
  }
}

TEST(KinectNoise, FlickersBetweenNeighbouringLevelsInBlobs) {
  const TrueView view = view_of(world_of(wall_at(2.0f)), small_kinect());
  const DepthImage a = exposed(view, 0), b = exposed(view, 1);
  const auto levels = kinect_levels(kMm);
  const auto level_of = [&](std::uint16_t value) {
    return std::lower_bound(levels.begin(), levels.end(), value) - levels.begin();
  };
  double both = 0, changed = 0, far = 0, beside = 0, beside_changed = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x + 1 < a.width(); ++x) {
      if (!a(x, y) || !b(x, y) || !a(x + 1, y) || !b(x + 1, y)) continue;
      ++both;
      const auto apart = std::abs(level_of(a(x, y)) - level_of(b(x, y)));
      changed += apart > 0;
      far += apart > 2;
      if (apart > 0) {
        ++beside;
        beside_changed += a(x + 1, y) != b(x + 1, y);
      }
    }
  }
  EXPECT_NEAR(changed / both, 0.36, 0.1);  // a real Kinect at rest: 0.3 to 0.4
  EXPECT_LT(far / both, 0.001);
  EXPECT_GT(beside_changed / beside, 1.4 * changed / both);  // neighbours change together
}

TEST(KinectNoise, ThrowsTheProjectorsShadowToTheLeft) {
  const float near = 1.2f, far = 2.4f;
  Scene scene = wall_at(far);
  scene.add(panel({0, 0, near}, {0.25f, 0, 0}, {0, 5, 0}, 0, 10));
  const CameraModel model = kinect_model(640, 480);
  const DepthImage depth = exposed(view_of(world_of(std::move(scene)), model));
  const double expected = shadow_width_px(model.fx, near, far);
  const int edge = static_cast<int>(std::lround(model.cx - 0.25 / near * model.fx));
  double total = 0;
  for (int y = 0; y < 480; ++y) {
    int width = 0;
    for (int x = edge - 40; x < edge + 4; ++x) width += depth(x, y) == 0;
    total += width;
  }
  EXPECT_NEAR(total / 480, expected, 1.5);
  EXPECT_NEAR(expected, 18.3, 0.1);
  const int right = static_cast<int>(std::lround(model.cx + 0.25 / near * model.fx));
  double beyond = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = right - 4; x < right + 40; ++x) beyond += depth(x, y) == 0;
  }
  EXPECT_LT(beyond / 480, 1.5);
}

TEST(KinectNoise, SeesNothingTooNearOrTooFar) {
  EXPECT_EQ(hole_share(exposed(view_of(world_of(wall_at(0.45f)), small_kinect()))), 1);
  EXPECT_EQ(hole_share(exposed(view_of(world_of(wall_at(5.4f)), small_kinect()))), 1);
}

TEST(KinectNoise, IsBlindInTheRightmostColumns) {
  const DepthImage depth = exposed(view_of(world_of(wall_at(1.5f)), kinect_model(640, 480)));
  for (int y = 0; y < 480; ++y) {
    for (int x = 632; x < 640; ++x) ASSERT_EQ(depth(x, y), 0);
  }
  EXPECT_LT(hole_share(depth), 0.02);
}

TEST(KinectNoise, LosesDarkAndGrazingSurfaces) {
  EXPECT_GT(hole_share(exposed(view_of(world_of(wall_at(2, 0.02f)), small_kinect()))), 0.98);
  const double partly = hole_share(exposed(view_of(world_of(wall_at(2, 0.12f)), small_kinect())));
  EXPECT_GT(partly, 0.2);
  EXPECT_LT(partly, 0.9);
  // A floor 10 cm below the camera: the angle of incidence grows towards the horizon.
  Scene floor = wall_at(50);
  floor.add(panel({0, 0.1f, 4}, {8, 0, 0}, {0, 0, -4}, 0, 10));
  const DepthImage depth = exposed(view_of(world_of(std::move(floor)), small_kinect()));
  int last_seen = 0;
  for (int y = 0; y < 240; ++y) last_seen = std::max<int>(last_seen, depth(160, y));
  EXPECT_LT(last_seen, 1500);
}

TEST(KinectNoise, LosesMoreWhereOtherProjectorsShine) {
  const TrueView view = view_of(world_of(wall_at(2.0f)), small_kinect());
  KinectNoise alone(small_kinect(), kMm, 1, 0), together(small_kinect(), kMm, 1, 0);
  together.set_interference(Image<float>(320, 240, 1.0f));
  const DepthImage a = exposed(alone, view, 0), b = exposed(together, view, 0);
  EXPECT_GT(hole_share(b) - hole_share(a), 0.01);
  EXPECT_LT(hole_share(b) - hole_share(a), 0.08);
}

TEST(KinectNoise, IsDecidedBySeedCameraAndFrame) {
  const TrueView view = view_of(world_of(wall_at(2.0f)), small_kinect());
  EXPECT_EQ(exposed(view, 4, 1, 0), exposed(view, 4, 1, 0));
  EXPECT_NE(exposed(view, 4, 1, 0), exposed(view, 5, 1, 0));
  EXPECT_NE(exposed(view, 4, 1, 0), exposed(view, 4, 2, 0));
  EXPECT_NE(exposed(view, 4, 1, 0), exposed(view, 4, 1, 1));
}

}  // namespace
}  // namespace copresence::simulation
