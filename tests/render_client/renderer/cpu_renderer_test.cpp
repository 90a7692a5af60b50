#include "render_client/renderer/cpu_renderer.h"

#include <gtest/gtest.h>

#include "common/flow/worker_pool.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

constexpr int kWidth = 640, kHeight = 360;

// A camera that looks at a surface, and owns what it sees.
struct Looking {
  RgbdFrame frame;
  CameraView view;

  Looking(const CameraModel& model, const Surface& surface,
          const std::optional<Paint>& paint = Paint(gradient), const Rigid3& world_from_camera = {})
      : frame(frame_of(model, surface, paint)) {
    view.model = model;
    view.unit = DepthUnit::k100Micrometres;
    view.version = 1;
    view.world_from_camera = world_from_camera;
  }
};

MergedView render(std::vector<Looking*> cameras, const VirtualCamera& eye, int largest_block = 16,
                  int threads = 1) {
  flow::WorkerPool workers(threads, "test");
  const auto renderer = make_cpu_renderer(workers, {.largest_block = largest_block});
  std::vector<CameraView> views;
  for (Looking* camera : cameras) {
    views.push_back(camera->view);
    views.back().frame = &camera->frame;
  }
  MergedView view;
  EXPECT_TRUE(renderer->render(views, eye, {.color = true, .depth = true}, view));
  return view;
}

// The point that a pixel of the view shows.
Eigen::Vector3d shown_point(const MergedView& view, const VirtualCamera& eye, int x, int y) {
  return eye.world_from_eye * unproject(eye.lens, {double(x), double(y)}, view.depth_m(x, y));
}

int count_shown(const MergedView& view) {
  int shown = 0;
  for (float depth : view.depth_m.pixels()) shown += depth > 0;
  return shown;
}

TEST(CpuRenderer, ShowsATiltedPlaneWhereItIsFromAMovedEye) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.2, 1).normalized();
  Looking camera(kinect_model(), plane(n, 2));
  for (double degrees : {-25.0, 0.0, 20.0}) {
    const VirtualCamera eye = orbiting_eye(kWidth, kHeight, degrees, 2);
    const MergedView view = render({&camera}, eye);
    EXPECT_GT(count_shown(view), kWidth * kHeight / 4);
    double worst = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (view.depth_m(x, y) > 0)
          worst = std::max(worst, std::abs(n.dot(shown_point(view, eye, x, y)) - 2));
      }
    }
    EXPECT_LT(worst, 0.0002) << degrees;  // the depth image's own 0.1 mm, seen from aside
  }
}

TEST(CpuRenderer, ShowsTheColorThatLiesOnThePoint) {
  Looking camera(kinect_model(), plane(Eigen::Vector3d(0.3, 0.2, 1).normalized(), 2));
  const VirtualCamera eye = orbiting_eye(kWidth, kHeight, 20, 2);
  const MergedView view = render({&camera}, eye);
  for (int y = 0; y < kHeight; y += 3) {
    for (int x = 0; x < kWidth; x += 3) {
      if (view.depth_m(x, y) == 0) continue;
      const Eigen::Vector2d pixel = project(camera.view.model, shown_point(view, eye, x, y));
      EXPECT_NEAR(view.color(x, y).r, 30 + pixel.x() * 200 / 640, 1.6) << x << ' ' << y;
      EXPECT_NEAR(view.color(x, y).g, 30 + pixel.y() * 200 / 480, 1.6) << x << ' ' << y;
      EXPECT_EQ(view.color(x, y).a, 255);
    }
  }
}

TEST(CpuRenderer, GivesTheSamePictureWithAnyNumberOfThreads) {
  Looking one(kinect_model(), together({wall(3), sphere({0, 0, 2}, 0.4)}));
  Looking two(kinect_model(), wall(3.01), Paint(plain({200, 100, 50})));
  measure_like_a_kinect(one.frame, 0.05, 1);
  const VirtualCamera eye = orbiting_eye(kWidth, kHeight, 10, 2);
  const MergedView single = render({&one, &two}, eye, 16, 1);
  for (int threads : {2, 3, 8}) {
    const MergedView several = render({&one, &two}, eye, 16, threads);
    EXPECT_EQ(several.color, single.color);
    EXPECT_EQ(several.depth_m, single.depth_m);
    EXPECT_EQ(several.camera, single.camera);
    EXPECT_EQ(several.quality, single.quality);
  }
}

}  // namespace
}  // namespace copresence::renderer
