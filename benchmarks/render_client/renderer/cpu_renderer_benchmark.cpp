// What a view costs on the CPU: 640x480 frames of a furnished room as a Kinect measures it, a new one for
// every view. "Time" is the wall's and "CPU" that of all threads together, milliseconds per view.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "common/flow/worker_pool.h"
#include "render_client/renderer/cpu/band_merge.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/cpu/source_texture.h"
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

  explicit Room(int count, bool is_one_room = true) {
    frames.reserve(count);
    for (int i = 0; i < count; ++i) {
      const double x_m = 0.4 * (i - (count - 1) / 2.0);
      const Surface seen = is_one_room ? room_seen_from(x_m) : wall(1.5 + i);
      frames.push_back(frame_of(kinect_model(), seen, Paint(gradient)));
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
  InlineExecutor workers;
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
  FlatBlocks flat;
  MeshBlocks blocks;
  Image<float> cosines;
  Texture texture;
  BlockOutlines outlines;
  DepthMesh mesh;
  for (auto _ : state) {
    invert_depth(room.frames[0].depth, 1e-4, inverse);
    find_flat_blocks(inverse, {kKinectV1Noise, 1 / 585.0F}, flat);
    measure_tilts(inverse, flat, kinect_model(), cosines);
    make_texture(room.frames[0], cosines, Eigen::Matrix<float, 3, 4>::Identity(), texture);
    list_blocks(inverse, flat, 16, blocks);
    outlines.draw(flat, blocks, inverse);
    build_mesh(inverse, blocks, {ray, false}, {kKinectV1Noise, 1 / 585.0F}, mesh);
    benchmark::DoNotOptimize(mesh);
  }
  state.counters["vertices"] = double(mesh.x.size());
  state.counters["quads"] = double(mesh.quads.size());
}
BENCHMARK(new_frame)->Unit(benchmark::kMillisecond);

// Merging alone, colours and outlines included, on one thread of a 1280x720 view: each band is merged when it has just been drawn, as
// the renderer does it, and only that is timed. What a second camera adds to one is the difference. `one_room`: whether
// the cameras see the same surfaces, which are mixed nearly everywhere, or walls behind each other.
void merge(benchmark::State& state) {
  constexpr int kRows = 16;
  Room room(int(state.range(0)), state.range(1) != 0);
  const VirtualCamera eye = orbiting_eye(1280, 720, 10, 2);
  const auto near_m = float(eye.near_m);
  const auto ray = rays(kinect_model());
  struct Drawn {
    DepthMesh mesh;
    Texture texture;
    ProjectionMatrix matrix;
    std::vector<ViewVertex> vertices;
    std::vector<PatchExtent> extents;
  };
  std::vector<Drawn> drawn(room.cameras.size());
  std::vector<MergeSource> sources;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    InverseDepth inverse;
    FlatBlocks flat;
    MeshBlocks blocks;
    Image<float> cosines;
    BlockOutlines outlines;
    Drawn& d = drawn[i];
    invert_depth(room.frames[i].depth, 1e-4, inverse);
    find_flat_blocks(inverse, {kKinectV1Noise, 1 / 585.0F}, flat);
    measure_tilts(inverse, flat, kinect_model(), cosines);
    make_texture(room.frames[i], cosines, Eigen::Matrix<float, 3, 4>::Identity(), d.texture);
    list_blocks(inverse, flat, 16, blocks);
    outlines.draw(flat, blocks, inverse);
    build_mesh(inverse, blocks, {ray, false}, {kKinectV1Noise, 1 / 585.0F}, d.mesh);
    d.matrix = projection_matrix(eye, room.cameras[i].world_from_camera);
    d.vertices.resize(d.mesh.vertices());
    d.extents.resize(d.mesh.patches.size());
    project_patches(d.mesh, 0, d.mesh.patches.size(), d.matrix, near_m, d.vertices, d.extents);
    sources.push_back(merge_source(room.cameras[i], eye, d.texture));
  }
  MergedView view;
  view.width = eye.lens.width;
  view.height = eye.lens.height;
  view.color.resize(view.width, view.height);
  std::vector<Band> bands(drawn.size());
  for (auto _ : state) {
    std::chrono::duration<double> merging{};
    for (int top = 0; top < view.height; top += kRows) {
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const Drawn& d = drawn[i];
        bands[i].begin(view.width, top, kRows, float(eye.far_m), 640, 480);
        for (std::size_t p = 0; p < d.extents.size(); ++p) {
          const PatchExtent& extent = d.extents[p];
          if (extent.behind || extent.bottom < float(top - 1) || extent.top > float(top + kRows)) continue;
          draw_patch(d.mesh, d.mesh.patches[p], extent, d.vertices, d.matrix, near_m, bands[i]);
        }
      }
      const auto begin = std::chrono::steady_clock::now();
      merge_band(sources, bands, {.color = true}, view);
      merging += std::chrono::steady_clock::now() - begin;
    }
    state.SetIterationTime(merging.count());
    benchmark::DoNotOptimize(view.color.data());
  }
}
BENCHMARK(merge)
    ->ArgNames({"cameras", "one_room"})
    ->ArgsProduct({{1, 2, 4}, {1, 0}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::renderer
