// Measures the playback of a recording, from the file to RgbdFrames of 640x480. "user" and "system"
// are the CPU times of all threads per frame.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "capture_server/recording/oni_check.h"
#include "capture_server/sensor/source.h"
#include "tests/support/real_recordings.h"

namespace copresence {
namespace {

double ms(const timeval& time) {
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
}

void check(benchmark::State& state) {
  const auto path = test::real_recording("office.oni");
  if (!path) return state.SkipWithError("no ../shared/recordings/office.oni here");
  for (auto _ : state) benchmark::DoNotOptimize(recording::check(*path));
}
BENCHMARK(check)->Name("recording_check/office.oni")->Unit(benchmark::kMillisecond);

void play(benchmark::State& state, const char* name, sensor::SourceSettings::Pace pace) {
  const auto path = test::real_recording(name);
  if (!path) return state.SkipWithError("no ../shared/recordings here");
  const auto source = sensor::open_source(*path, {pace, true});
  if (!source) return state.SkipWithError(source.error().what.c_str());
  benchmark::DoNotOptimize((*source)->next({}));
  rusage before{}, after{};
  double lateness_ms = 0;
  getrusage(RUSAGE_SELF, &before);
  for (auto _ : state) {
    const auto frame = (*source)->next({});
    if (!frame) return state.SkipWithError(frame.error().what.c_str());
    lateness_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                             frame->metadata.captured_at)
                       .count();
  }
  getrusage(RUSAGE_SELF, &after);
  const auto frames = static_cast<double>(state.iterations());
  state.counters["user_ms"] = (ms(after.ru_utime) - ms(before.ru_utime)) / frames;
  state.counters["system_ms"] = (ms(after.ru_stime) - ms(before.ru_stime)) / frames;
  state.counters["handed_over_after_ms"] = lateness_ms / frames;
}
using Pace = sensor::SourceSettings::Pace;
BENCHMARK_CAPTURE(play, fast_office, "office.oni", Pace::kFast)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(300);
BENCHMARK_CAPTURE(play, fast_depth_only, "person.oni", Pace::kFast)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(300);
BENCHMARK_CAPTURE(play, real_office, "office.oni", Pace::kReal)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);

}  // namespace
}  // namespace copresence
