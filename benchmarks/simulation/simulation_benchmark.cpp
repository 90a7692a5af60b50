// Measures the CPU time of a simulated 640x480 camera, per frame and before the first frame.

#include <benchmark/benchmark.h>

#include "simulation/sensor/simulated_kinect.h"

namespace copresence::simulation {
namespace {

std::shared_ptr<const LitScene> room() {
  static const auto kRoom = std::make_shared<const LitScene>(LitScene::of_world("room").value());
  return kRoom;
}

TrueCamera camera() {
  return TrueCamera::make(room(), kinect_model(640, 480), kinect_poses(1)[0]).value();
}

void make_scene_with_light(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(LitScene::of_world("room").value());
}
BENCHMARK(make_scene_with_light)->Unit(benchmark::kMillisecond);

void trace_background(benchmark::State& state) {
  room();
  for (auto _ : state) benchmark::DoNotOptimize(camera());
}
BENCHMARK(trace_background)->Unit(benchmark::kMillisecond);

void trace_person(benchmark::State& state) {
  TrueCamera eye = camera();
  std::uint64_t frame = 0;
  for (auto _ : state) benchmark::DoNotOptimize(&eye.trace(phase_of_frame(frame++, kPeriodFrames)));
}
BENCHMARK(trace_person)->Unit(benchmark::kMillisecond);

void dots_of_a_view(benchmark::State& state) {
  TrueCamera eye = camera();
  const TrueView& view = eye.trace(0);
  DotImage dots;
  for (auto _ : state) project_dots(eye.model(), view, dots);
}
BENCHMARK(dots_of_a_view)->Unit(benchmark::kMillisecond);

void add_kinect_noise(benchmark::State& state) {
  TrueCamera eye = camera();
  DotImage dots;
  project_dots(eye.model(), eye.trace(0), dots);
  KinectNoise noise(eye.model(), DepthUnit::kMillimetre, 1, 0);
  DepthImage depth(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) noise.add_noise(dots, frame++, depth.pixels());
}
BENCHMARK(add_kinect_noise)->Unit(benchmark::kMillisecond);

void apply_color_response(benchmark::State& state) {
  TrueCamera eye = camera();
  const ColorResponse response(640, 480, 1, 1);
  const TrueView& view = eye.trace(0);
  NoiseFreeColors colors;
  for (auto _ : state) response.apply_response(view.color, colors);
}
BENCHMARK(apply_color_response)->Unit(benchmark::kMillisecond);

void add_color_noise(benchmark::State& state) {
  TrueCamera eye = camera();
  const ColorResponse response(640, 480, 1, 1);
  NoiseFreeColors colors;
  response.apply_response(eye.trace(0).color, colors);
  ColorImage picture(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) response.add_noise(colors, frame++, picture.pixels());
}
BENCHMARK(add_color_noise)->Unit(benchmark::kMillisecond);

void whole_frame(benchmark::State& state) {
  auto kinect =
      SimulatedKinect::make(room(), kinect_model(640, 480), kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
          .value();
  DepthImage depth;
  ColorImage color;
  std::uint64_t frame = 0;
  for (auto _ : state) {
    kinect.capture(phase_of_frame(frame, kPeriodFrames), frame, depth, color);
    ++frame;
  }
}
BENCHMARK(whole_frame)->Unit(benchmark::kMillisecond);

SimulatedKinect kinect() {
  return SimulatedKinect::make(room(), kinect_model(640, 480), kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
      .value();
}

// Measures the work of a live camera before its first frame, in a scene that exists already.
void precompute_live(benchmark::State& state) {
  room();
  for (auto _ : state) {
    SimulatedKinect made = kinect();
    made.precompute();
  }
}
BENCHMARK(precompute_live)->Unit(benchmark::kMillisecond);

void live_frame(benchmark::State& state) {
  SimulatedKinect live = kinect();
  live.precompute();
  DepthImage depth(640, 480);
  ColorImage color(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) {
    live.capture_live_depth(frame, depth.pixels());
    live.capture_live_color(frame, color.pixels());
    ++frame;
  }
}
BENCHMARK(live_frame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::simulation
