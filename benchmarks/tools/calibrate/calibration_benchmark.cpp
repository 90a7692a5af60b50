// Measures the accuracy and time of marker calibration on 50 random layouts. The counters are in
// millimetres and degrees.

#include <benchmark/benchmark.h>

#include "tests/tools/calibrate/geometry/rig.h"

namespace copresence::calibrate {
namespace {

void report(benchmark::State& state, const Errors& errors) {
  state.counters["shift_p50_mm"] = Errors::at(errors.shift_mm, 0.5);
  state.counters["shift_p95_mm"] = Errors::at(errors.shift_mm, 0.95);
  state.counters["angle_p50_deg"] = Errors::at(errors.angle_deg, 0.5);
  state.counters["angle_p95_deg"] = Errors::at(errors.angle_deg, 0.95);
  state.counters["cameras"] = static_cast<double>(errors.shift_mm.size());
}

const LayoutErrors& all_layouts() {
  static const LayoutErrors errors = run_layouts(0, 50, 10);
  return errors;
}

void rigid_on_50_layouts(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(&all_layouts());
  report(state, all_layouts().rigid);
  state.counters["expected_over_actual"] = all_layouts().rigid.expected_over_actual();
  state.counters["marker_depth_steps"] = all_layouts().plane_steps;
}
BENCHMARK(rigid_on_50_layouts)->Iterations(1);

void linear_on_50_layouts(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(&all_layouts());
  report(state, all_layouts().linear);
  state.counters["refused"] = all_layouts().linear_refused;
}
BENCHMARK(linear_on_50_layouts)->Iterations(1);

void rigid_with_depth_of_one_pixel(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(&all_layouts());
  report(state, all_layouts().of_one_pixel);
  state.counters["marker_depth_steps"] = all_layouts().pixel_steps;
}
BENCHMARK(rigid_with_depth_of_one_pixel)->Iterations(1);

void fit_world_of_six_markers(benchmark::State& state) {
  const Rig rig = make_rig(1, static_cast<int>(state.range(0)));
  const auto observations = observations_with_noise(rig, 0.3);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        fit_world(observations, rig.names(), {0, rig.world_from_camera[0], Solver::kRigid}));
  }
}
BENCHMARK(fit_world_of_six_markers)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::calibrate
