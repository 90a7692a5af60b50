// Measures the GL renderer with cameras of 640x480 and a view of 1280x720. Without a graphics card,
// the software rasteriser is measured.

#include <benchmark/benchmark.h>

#include "render_client/renderer/gl/gl_renderer.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

std::vector<RgbdFrame> frames_of(int cameras) {
  const Surface room = together({plane({0.3, 0, 1}, 3), plane({-0.5, 0, 1}, 3.2), plane({0, 1, 0}, 0.9),
                                 sphere({0.1, 0.2, 1.8}, 0.35)});
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < cameras; ++i) {
    frames.push_back(frame_of(kinect_model(), room, Paint(gradient)));
    measure_like_a_kinect(frames.back(), 0.04, unsigned(i));
  }
  return frames;
}

// The arguments are the number of cameras, whether each camera has a new frame, and whether the
// colours are copied to the host.
void gl_renderer_1280x720(benchmark::State& state) {
  const auto context = gl::Context::headless();
  if (!context) return state.SkipWithError(context.error().what.c_str());
  const auto renderer = make_gl_renderer(**context);
  if (!renderer) return state.SkipWithError(renderer.error().what.c_str());
  state.SetLabel((*context)->renderer_name());
  const std::vector<RgbdFrame> frames = frames_of(int(state.range(0)));
  std::vector<CameraView> cameras(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    cameras[i].version = 1;
    cameras[i].frame = &frames[i];
    cameras[i].model = kinect_model();
    cameras[i].unit = DepthUnit::k100Micrometres;
    cameras[i].world_from_camera.translation.x() = 0.002 * double(i);
  }
  const ViewPose eye = orbiting_eye(1280, 720, 15, 2);
  MergedView view;
  (void)(*renderer)->render(cameras, eye, {}, view);  // The first call compiles shaders.
  for (auto _ : state) {
    if (state.range(1)) {
      for (CameraView& camera : cameras) ++camera.version;
    }
    const auto rendered = (*renderer)->render(cameras, eye, {.color = state.range(2) != 0}, view);
    if (!rendered) return state.SkipWithError(rendered.error().what.c_str());
    (*context)->finish();
  }
}
BENCHMARK(gl_renderer_1280x720)
    ->ArgNames({"cameras", "new_frames", "to_host"})
    ->Args({1, 1, 1})
    ->Args({2, 1, 1})
    ->Args({4, 1, 1})
    ->Args({2, 0, 0})
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::renderer
