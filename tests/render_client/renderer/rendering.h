#pragma once

// Cameras with frames of their own, and views of them by the CPU renderer.

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "common/flow/worker_pool.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {

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

inline std::vector<CameraView> views_of(const std::vector<Looking*>& cameras) {
  std::vector<CameraView> views;
  for (Looking* camera : cameras) {
    views.push_back(camera->view);
    views.back().frame = &camera->frame;
  }
  return views;
}

inline MergedView render(const std::vector<Looking*>& cameras, const ViewPose& eye, int largest_block = 16,
                         int threads = 1) {
  flow::WorkerPool workers(threads, "test");
  const auto renderer = make_cpu_renderer(workers, {.largest_block = largest_block});
  MergedView view;
  EXPECT_TRUE(renderer->render(views_of(cameras), eye, {.color = true, .depth = true}, view));
  return view;
}

/// The point in the world that a pixel of the view shows.
inline Eigen::Vector3d shown_point(const MergedView& view, const ViewPose& eye, int x, int y) {
  return eye.world_from_eye * unproject(eye.intrinsics, {double(x), double(y)}, view.depth_m(x, y));
}

inline int count_shown(const MergedView& view) {
  int shown = 0;
  for (float depth : view.depth_m.pixels()) shown += depth > 0;
  return shown;
}

/// Calls visit(x, y) for every pixel that shows a surface.
template <class Visit>
void for_each_shown(const MergedView& view, Visit&& visit) {
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (view.depth_m(x, y) > 0) visit(x, y);
    }
  }
}

/// An eye at the pose of the camera.
inline ViewPose eye_at_origin(int width, int height) {
  return orbiting_eye(width, height, 0, 1);
}

inline bool near_color(Rgba8 a, Rgb8 b, int tolerance = 1) {
  return std::abs(a.r - b.r) <= tolerance && std::abs(a.g - b.g) <= tolerance &&
         std::abs(a.b - b.b) <= tolerance;
}

}  // namespace copresence::renderer
