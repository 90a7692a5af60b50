// What a view costs on the CPU: 640x480 frames of a furnished room as a Kinect measures it, a new one for
// every view. "Time" is the wall's and "CPU" that of all threads together, milliseconds per view.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "common/flow/worker_pool.h"
#include "render_client/renderer/cpu_renderer.h"
#include "render_client/renderer/depth_mesh.h"
#include "render_client/renderer/source_texture.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

// Two walls, a floor, somebody in the middle and a table's worth of round things, for a camera moved
// sideways.
Surface room_seen_from(double x_m) {
  std::vector<Surface> parts = {wall(3.5), plane({0, 1, 0}, 1.1), plane({-1, 0, 0}, 1.6 + x_m)};
  parts.push_back(sphere({0.1 - x_m, -0.35, 1.9}, 0.13));
  for (int i = 0; i < 8; ++i)
    parts.push_back(sphere({0.1 - x_m, -0.1 + i * 0.12, 1.95 + 0.02 * (i % 2)}, 0.2));
  for (int i = 0; i < 6; ++i) {
    parts.push_back(sphere({-1.0 + i * 0.35 - x_m, 0.75, 2.4 - (i % 3) * 0.2}, 0.12));
  }
  return together(parts);
}

// Cameras in a row, 40 cm apart, and everything they see.
struct Room {
  std::vector<RgbdFrame> frames;
  std::vector<CameraView> cameras;

  explicit Room(int count) {
    frames.reserve(count);
    for (int i = 0; i < count; ++i) {
      const double x_m = 0.4 * (i - (count - 1) / 2.0);
      frames.push_back(frame_of(kinect_model(), room_seen_from(x_m), Paint(gradient)));
      measure_like_a_kinect(frames.back(), 0.04, unsigned(i));
      CameraView camera;
      camera.frame = &frames.back();
      camera.model = kinect_model();
      camera.unit = DepthUnit::k100Micrometres;
      camera.world_from_camera.translation.x() = x_m;
      cameras.push_back(camera);
    }
  }
};

// Arguments: cameras, width and height of the view, threads.
void whole_view(benchmark::State& state) {
  Room room(int(state.range(0)));
  const VirtualCamera eye = orbiting_eye(int(state.range(1)), int(state.range(2)), 10, 2);
  flow::WorkerPool workers(int(state.range(3)), "render");
  const auto renderer = make_cpu_renderer(workers);
  MergedView view;
  for (auto _ : state) {
    for (CameraView& camera : room.cameras) ++camera.version;
    benchmark::DoNotOptimize(renderer->render(room.cameras, eye, {.color = true}, view));
  }
}
BENCHMARK(whole_view)
    ->ArgNames({"cameras", "width", "height", "threads"})
    ->ArgsProduct({{1, 2, 4}, {1280}, {720}, {1, 2}})
    ->ArgsProduct({{1, 2, 4}, {640}, {360}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// The same without new frames: what moving the eye costs.
void moved_eye(benchmark::State& state) {
  Room room(int(state.range(0)));
  const VirtualCamera eye = orbiting_eye(1280, 720, 10, 2);
  NoWorkers workers;
  const auto renderer = make_cpu_renderer(workers);
  MergedView view;
  for (auto _ : state) benchmark::DoNotOptimize(renderer->render(room.cameras, eye, {.color = true}, view));
}
BENCHMARK(moved_eye)->ArgName("cameras")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);

// One camera's frame to a mesh and a texture.
void new_frame(benchmark::State& state) {
  Room room(1);
  const auto ray = rays(kinect_model());
  InverseDepth inverse;
  FlatBlocks blocks;
  Image<float> cosines;
  Texture texture;
  BlockOutlines outlines;
  DepthMesh mesh;
  for (auto _ : state) {
    invert_depth(room.frames[0].depth, 1e-4, inverse);
    find_flat_blocks(inverse, 1 / 585.0F, blocks);
    measure_tilts(inverse, blocks, kinect_model(), cosines);
    make_texture(room.frames[0], cosines, Eigen::Matrix<float, 3, 4>::Identity(), texture);
    outlines.draw(blocks, 16, inverse);
    build_mesh(inverse, blocks, 16, ray, 1 / 585.0F, mesh);
    benchmark::DoNotOptimize(mesh);
  }
  state.counters["vertices"] = double(mesh.x.size());
  state.counters["quads"] = double(mesh.quads.size());
}
BENCHMARK(new_frame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::renderer
