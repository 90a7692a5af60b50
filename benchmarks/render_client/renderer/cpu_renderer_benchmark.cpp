// Measures the CPU renderer. The cameras have new 640x480 frames of a furnished room for every
// view, with the noise of a Kinect. The results are elapsed time and the CPU time of all threads,
// in milliseconds per view.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "common/flow/worker_pool.h"
#include "render_client/renderer/cpu/block_stitching.h"
#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/cpu/tile_merge.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

// Returns a room with a person, as seen by a camera that is shifted sideways by `x_m`.
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

// Cameras in a row, 40 cm apart, and their frames.
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

// Measures a view of new frames. The arguments are the number of cameras, the width and height of
// the view, and the number of threads.
void whole_view(benchmark::State& state) {
  Room room(int(state.range(0)));
  const ViewPose eye = orbiting_eye(int(state.range(1)), int(state.range(2)), 10, 2);
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

// Measures a view without new frames, after the eye has moved. The arguments are the same.
void moved_eye(benchmark::State& state) {
  Room room(int(state.range(0)));
  const ViewPose eye = orbiting_eye(1280, 720, 10, 2);
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  MergedView view;
  for (auto _ : state) benchmark::DoNotOptimize(renderer->render(room.cameras, eye, {.color = true}, view));
}
BENCHMARK(moved_eye)->ArgName("cameras")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);

// Measures the same with extended surfaces in the parts that no camera sees.
void extended_view(benchmark::State& state) {
  Room room(2);
  const ViewPose eye = orbiting_eye(1280, 720, 10, 2);
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_unseen({.show = UnseenStyle::Show::kExtend});
  MergedView view;
  for (auto _ : state) benchmark::DoNotOptimize(renderer->render(room.cameras, eye, {.color = true}, view));
  state.counters["extended"] = view.shares->extended;
}
BENCHMARK(extended_view)->Unit(benchmark::kMillisecond);

// Measures a new frame of a remembered background, which fills a tenth of the picture.
void new_remembered_background(benchmark::State& state) {
  Room room(1);
  for (int y = 0; y < room.frames[0].depth.height(); ++y) {
    const auto row = room.frames[0].depth.row(y);
    std::fill(row.begin(), row.begin() + 250, std::uint16_t{0});
    std::fill(row.begin() + 314, row.end(), std::uint16_t{0});
  }
  room.cameras[0].is_remembered = true;
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_unseen({.show = UnseenStyle::Show::kExtend});
  for (auto _ : state) {
    ++room.cameras[0].version;
    renderer->prepare(room.cameras);
  }
}
BENCHMARK(new_remembered_background)->Unit(benchmark::kMillisecond);

// Measures making the mesh and texture of one camera's frame.
void new_frame(benchmark::State& state) {
  Room room(1);
  const auto ray = rays(kinect_model());
  InverseDepth inverse;
  PlanarBlocks planar;
  MeshBlocks blocks;
  Image<float> incidences;
  CameraTexture texture;
  BlockStitching stitching;
  DepthMesh mesh;
  for (auto _ : state) {
    invert_depth(room.frames[0].depth, 1e-4, inverse);
    find_planar_blocks(inverse, {kKinectV1Noise, 1 / 585.0F}, planar);
    measure_incidence(inverse, planar, kinect_model(), incidences);
    make_texture(room.frames[0], incidences, Eigen::Matrix<float, 3, 4>::Identity(), texture);
    list_blocks(inverse, planar, 16, blocks);
    stitching.draw(planar, blocks, inverse);
    build_mesh(inverse, blocks, {ray, false}, {kKinectV1Noise, 1 / 585.0F}, mesh);
    benchmark::DoNotOptimize(mesh);
  }
  state.counters["vertices"] = double(mesh.x.size());
  state.counters["quads"] = double(mesh.quads.size());
}
BENCHMARK(new_frame)->Unit(benchmark::kMillisecond);

// Measures merging with colours and silhouettes, on one thread for a 1280x720 view. As in the
// renderer, each tile is merged right after it is drawn, but only the merge is timed. With
// `one_room`, the cameras see the same surfaces, and nearly all pixels are blended. Otherwise each
// camera sees a wall at a different distance, and only the nearest wall is visible.
void merge(benchmark::State& state) {
  constexpr int kRows = 16;
  Room room(int(state.range(0)), state.range(1) != 0);
  const ViewPose eye = orbiting_eye(1280, 720, 10, 2);
  const auto near_m = float(eye.near_m);
  const auto ray = rays(kinect_model());
  struct Drawn {
    DepthMesh mesh;
    CameraTexture texture;
    ProjectionMatrix matrix;
    std::vector<ViewVertex> vertices;
    std::vector<PatchExtent> extents;
  };
  std::vector<Drawn> drawn(room.cameras.size());
  std::vector<MergeCamera> sources;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    InverseDepth inverse;
    PlanarBlocks planar;
    MeshBlocks blocks;
    Image<float> incidences;
    BlockStitching stitching;
    Drawn& d = drawn[i];
    invert_depth(room.frames[i].depth, 1e-4, inverse);
    find_planar_blocks(inverse, {kKinectV1Noise, 1 / 585.0F}, planar);
    measure_incidence(inverse, planar, kinect_model(), incidences);
    make_texture(room.frames[i], incidences, Eigen::Matrix<float, 3, 4>::Identity(), d.texture);
    list_blocks(inverse, planar, 16, blocks);
    stitching.draw(planar, blocks, inverse);
    build_mesh(inverse, blocks, {ray, false}, {kKinectV1Noise, 1 / 585.0F}, d.mesh);
    d.matrix = projection_matrix(eye, room.cameras[i].world_from_camera);
    d.vertices.resize(d.mesh.vertices());
    d.extents.resize(d.mesh.patches.size());
    project_patches(d.mesh, 0, d.mesh.patches.size(), d.matrix, near_m, d.vertices, d.extents);
    sources.push_back(merge_camera(room.cameras[i], eye, d.texture, 1));
  }
  MergedView view;
  view.width = eye.intrinsics.width;
  view.height = eye.intrinsics.height;
  view.color.resize(view.width, view.height);
  std::vector<Tile> tiles(drawn.size());
  for (auto _ : state) {
    std::chrono::duration<double> merging{};
    Image<float> unwanted;
    TileBorders borders;
    for (int top = 0; top < view.height; top += kRows) {
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const Drawn& d = drawn[i];
        tiles[i].begin(view.width, top, kRows, float(eye.far_m), 640, 480);
        for (std::size_t p = 0; p < d.extents.size(); ++p) {
          const PatchExtent& extent = d.extents[p];
          if (extent.behind || extent.bottom < float(top - 1) || extent.top > float(top + kRows)) continue;
          draw_patch(d.mesh, d.mesh.patches[p], extent, d.vertices, d.matrix, near_m, tiles[i]);
        }
      }
      const auto begin = std::chrono::steady_clock::now();
      const MergeSettings settings{.wanted = {.color = true},
                                   .background = {},
                                   .silhouette_step = kSilhouetteSteps * inverse_step(sources[0].noise)};
      merge_tile(sources, tiles, settings, view, unwanted, borders);
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
