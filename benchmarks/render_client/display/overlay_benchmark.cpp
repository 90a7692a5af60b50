// Measures what the overlay adds to a view of 1280x720 of two cameras. Without a graphics card, the
// software rasteriser draws the overlay, and the CPU renderer draws the view. Run it with
// --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true, so that other programs
// disturb both alike.

#include "render_client/display/overlay/overlay.h"

#include <benchmark/benchmark.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <thread>

#include "common/flow/worker_pool.h"
#include "common/gl/texture.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::overlay {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr int kViewsPerContent = 15;  // The content changes four times a second.

/// Two cameras with full graphs, all figures and all switches.
Content full_content() {
  Content content;
  content.figures.headings = {"camera",  "frames/s", "Mbit/s",   "latency ms", "age ms",
                              "dropped", "holes",    "error mm", "overlap mm"};
  content.figures.stages = {"capture", "fill",         "depth_encode", "video_encode",
                            "wire",    "video_decode", "depth_decode", "wait and render"};
  for (const char* name : {"left", "right"}) {
    CameraLine camera;
    camera.cells = {name, "30.0", "4.21", "48", "31", "encoder_busy 12", "8.4 %", "4.2", "6.1"};
    camera.stages_ms.assign(40, {4, 5, 3, 8, 2, 4, 3, 14});
    content.figures.cameras.push_back(camera);
  }
  content.figures.view = {{"views", "60.0 per second, each rendered in 8.1 ms"},
                          {"skew", "12.1 ms between the cameras' pictures"},
                          {"pixels", "89.5 % seen, 0.1 % remembered, 10.4 % extended, 0.0 % empty"}};
  for (int i = 0; i < 7; ++i) content.switches.push_back({i, "M", "merge", "blend"});
  content.notices = {"waiting for right at 127.0.0.1:7002, third try: connection refused"};
  return content;
}

// The argument says whether the figures are shown. Otherwise there is one line at the bottom.
void overlay_1280x720(benchmark::State& state) {
  const auto context = gl::Context::headless();
  if (!context) return state.SkipWithError(context.error().what.c_str());
  state.SetLabel((*context)->renderer_name());
  const gl::Texture texture(**context, gl::Format::kRgba8, kWidth, kHeight);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture.id(), 0);
  Overlay overlay(**context, {});
  if (state.range(0)) overlay.toggle_figures();
  int views = 0;
  for (auto _ : state) {
    if (views++ % kViewsPerContent == 0) overlay.set_content(full_content());
    overlay.draw(framebuffer, kWidth, kHeight);
    (*context)->finish();
  }
  glDeleteFramebuffers(1, &framebuffer);
}
BENCHMARK(overlay_1280x720)->ArgName("figures")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

void view_1280x720(benchmark::State& state) {
  using namespace renderer;
  flow::WorkerPool workers(int(std::max(1u, std::thread::hardware_concurrency())), "render");
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_unseen({.show = UnseenStyle::Show::kExtend});
  const Surface room = together({plane({0.3, 0, 1}, 3), plane({-0.5, 0, 1}, 3.2), plane({0, 1, 0}, 0.9),
                                 sphere({0.1, 0.2, 1.8}, 0.35)});
  std::vector<RgbdFrame> frames;
  for (unsigned i = 0; i < 2; ++i) {
    frames.push_back(frame_of(kinect_model(), room, Paint(gradient)));
    measure_like_a_kinect(frames.back(), 0.04, i);
  }
  std::vector<CameraView> cameras(2);
  for (std::size_t i = 0; i < 2; ++i) {
    cameras[i].frame = &frames[i];
    cameras[i].model = kinect_model();
    cameras[i].unit = DepthUnit::k100Micrometres;
    cameras[i].world_from_camera.translation.x() = 0.2 * double(i);
  }
  MergedView view;
  std::uint64_t version = 0;
  for (auto _ : state) {
    for (CameraView& camera : cameras) camera.version = ++version;  // Both cameras have a new frame.
    if (!renderer->render(cameras, orbiting_eye(kWidth, kHeight, 10, 2), {.color = true}, view))
      return state.SkipWithError("not drawn");
  }
}
BENCHMARK(view_1280x720)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace copresence::overlay
