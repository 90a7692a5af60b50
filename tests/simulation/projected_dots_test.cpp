#include "simulation/projected_dots.h"

#include <gtest/gtest.h>

#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

TrueView flat_view(const CameraModel& model, float z) {
  return {Image<float>(model.width, model.height, z), ColorImage(model.width, model.height),
          Image<float>(model.width, model.height, 0.8f)};
}

TEST(ProjectedDots, ComeBackWithTheDisparityOfAWallAndLessLightFromFar) {
  const CameraModel model = small_kinect();
  DotImage near, far;
  project_dots(model, flat_view(model, 1.0f), near);
  project_dots(model, flat_view(model, 3.0f), far);
  for (std::size_t i = 0; i < near.pixels().size(); ++i) {
    ASSERT_NEAR(near.data()[i].level, 351.3, 1e-3);
    ASSERT_NEAR(far.data()[i].level, 117.1, 1e-3);
    ASSERT_LT(far.data()[i].light, near.data()[i].light);
  }
}

TEST(ProjectedDots, DoNotReachWhatStandsLeftBehindSomethingNear) {
  const CameraModel model = kinect_model(640, 480);
  const float near = 1.2f, far = 2.4f;
  TrueView view = flat_view(model, far);
  for (int y = 0; y < 240; ++y) {  // the lower half is wall alone
    for (int x = 300; x < 400; ++x) view.depth_m(x, y) = near;
  }
  DotImage dots;
  project_dots(model, view, dots);
  const auto dark = [&](int y, int from, int to) {
    int count = 0;
    for (int x = from; x < to; ++x) count += dots(x, y).level == 0;
    return count;
  };
  for (int y = 0; y < 240; ++y) {
    ASSERT_EQ(dark(y, 0, 640), dark(y, 280, 300)) << y;  // all of it at the left edge
    ASSERT_NEAR(dark(y, 280, 300), shadow_width_px(model.fx, near, far), 1) << y;
  }
  for (int y = 240; y < 480; ++y) ASSERT_EQ(dark(y, 0, 640), 0) << y;
}

}  // namespace
}  // namespace copresence::simulation
