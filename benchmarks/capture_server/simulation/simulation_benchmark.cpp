// Milliseconds of processor time per 640x480 frame of a simulated camera, and what comes before the first.

#include <benchmark/benchmark.h>

#include "capture_server/simulation/simulated_kinect.h"

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

void add_kinect_noise(benchmark::State& state) {
  TrueCamera eye = camera();
  const TrueView& view = eye.look(0);
  KinectNoise noise(eye.model(), DepthUnit::kMillimetre, 1, 0);
  DepthImage depth;
  std::uint64_t frame = 0;
  for (auto _ : state) noise.expose(view, frame++, depth);
}
BENCHMARK(add_kinect_noise)->Unit(benchmark::kMillisecond);

void expose_colors(benchmark::State& state) {
  TrueCamera eye = camera();
  ColorResponse response(640, 480, 1, 1);
  ColorImage picture;
  std::uint64_t frame = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const TrueView& view = eye.look(phase_of_frame(frame, kPeriodFrames));
    state.ResumeTiming();
    response.expose(view.color, frame++, picture);
  }
}
BENCHMARK(expose_colors)->Unit(benchmark::kMillisecond)->Iterations(60);

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
  DepthImage depth;
  ColorImage color;
  std::uint64_t frame = 0;
  for (auto _ : state) live.expose_live(frame++, depth, color);
}
BENCHMARK(live_frame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::simulation
