// Milliseconds of processor time per 640x480 frame of a simulated camera, and what comes before the first.

#include <benchmark/benchmark.h>

#include "simulation/simulated_kinect.h"

namespace copresence::simulation {
namespace {

std::shared_ptr<const World> room() {
  static const auto kRoom = std::make_shared<const World>(World::make("room").value());
  return kRoom;
}

TrueCamera camera() {
  return TrueCamera::make(room(), kinect_model(640, 480), kinect_poses(1)[0]).value();
}

void make_world(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(World::make("room").value());
}
BENCHMARK(make_world)->Unit(benchmark::kMillisecond);

void trace_still_room(benchmark::State& state) {
  room();
  for (auto _ : state) benchmark::DoNotOptimize(camera());
}
BENCHMARK(trace_still_room)->Unit(benchmark::kMillisecond);

void look_at_person(benchmark::State& state) {
  TrueCamera eye = camera();
  std::uint64_t frame = 0;
  for (auto _ : state) benchmark::DoNotOptimize(&eye.look(phase_of_frame(frame++, kPeriodFrames)));
}
BENCHMARK(look_at_person)->Unit(benchmark::kMillisecond);

void glance_at_person(benchmark::State& state) {
  TrueCamera eye = camera();
  std::uint64_t frame = 0;
  for (auto _ : state) benchmark::DoNotOptimize(&eye.glance(phase_of_frame(frame++, kPeriodFrames)));
}
BENCHMARK(glance_at_person)->Unit(benchmark::kMillisecond);

void dots_of_a_view(benchmark::State& state) {
  TrueCamera eye = camera();
  const TrueView& view = eye.look(0);
  DotImage dots;
  for (auto _ : state) project_dots(eye.model(), view, dots);
}
BENCHMARK(dots_of_a_view)->Unit(benchmark::kMillisecond);

void add_kinect_noise(benchmark::State& state) {
  TrueCamera eye = camera();
  DotImage dots;
  project_dots(eye.model(), eye.look(0), dots);
  KinectNoise noise(eye.model(), DepthUnit::kMillimetre, 1, 0);
  DepthImage depth(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) noise.expose(dots, frame++, depth.pixels());
}
BENCHMARK(add_kinect_noise)->Unit(benchmark::kMillisecond);

void sense_colors(benchmark::State& state) {
  TrueCamera eye = camera();
  const ColorResponse response(640, 480, 1, 1);
  const TrueView& view = eye.look(0);
  SensedColors sensed;
  for (auto _ : state) response.sense(view.color, sensed);
}
BENCHMARK(sense_colors)->Unit(benchmark::kMillisecond);

void expose_colors(benchmark::State& state) {
  TrueCamera eye = camera();
  const ColorResponse response(640, 480, 1, 1);
  SensedColors sensed;
  response.sense(eye.look(0).color, sensed);
  ColorImage picture(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) response.expose(sensed, frame++, picture.pixels());
}
BENCHMARK(expose_colors)->Unit(benchmark::kMillisecond);

void whole_frame(benchmark::State& state) {
  auto kinect =
      SimulatedKinect::make(room(), kinect_model(640, 480), kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
          .value();
  DepthImage depth;
  ColorImage color;
  std::uint64_t frame = 0;
  for (auto _ : state) {
    kinect.expose(phase_of_frame(frame, kPeriodFrames), frame, depth, color);
    ++frame;
  }
}
BENCHMARK(whole_frame)->Unit(benchmark::kMillisecond);

SimulatedKinect kinect() {
  return SimulatedKinect::make(room(), kinect_model(640, 480), kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
      .value();
}

// What a live camera does before its first frame when its room is there.
void begin_live(benchmark::State& state) {
  room();
  for (auto _ : state) {
    SimulatedKinect made = kinect();
    made.foresee();
  }
}
BENCHMARK(begin_live)->Unit(benchmark::kMillisecond);

// From its first frame on.
void live_frame(benchmark::State& state) {
  SimulatedKinect live = kinect();
  live.foresee();
  DepthImage depth(640, 480);
  ColorImage color(640, 480);
  std::uint64_t frame = 0;
  for (auto _ : state) {
    live.expose_live_depth(frame, depth.pixels());
    live.expose_live_color(frame, color.pixels());
    ++frame;
  }
}
BENCHMARK(live_frame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::simulation
