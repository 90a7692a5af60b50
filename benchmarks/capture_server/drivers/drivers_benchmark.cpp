// What cameras cost through OpenNI2: the process's CPU time per 640x480 frame with everything that runs for it, what opening
// and closing leaves behind, and how soon an unplugged camera goes on. Kinects are fake (tests/support/fake_freenect); their
// pictures are drawn in this process, so a Kinect's figure is an upper bound of the driver's own.
//
// benchmarks/cameras.py runs it with the fake library found first.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>

#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {
namespace {

namespace fs = std::filesystem;

double cpu_ms() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto ms = [](const timeval& time) {
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
  };
  return ms(use.ru_utime) + ms(use.ru_stime);
}

double resident_kb() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * 4;
}

double entries(const char* folder) {
  return static_cast<double>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// A fake Kinect's file; empty where the fake library is not in place.
fs::path kinect() {
  const char* bus = std::getenv("COPRESENCE_FAKE_KINECTS");
  return bus ? fs::path(bus) / "BENCH1" : fs::path();
}

void stream(benchmark::State& state, const std::string& uri, int frames_before) {
  if (uri.starts_with("freenect") && kinect().empty())
    return state.SkipWithError("run benchmarks/cameras.py");
  if (uri.starts_with("freenect")) std::ofstream(kinect()).close();
  const auto source = open_device(uri);
  if (!source) return state.SkipWithError(source.error().what.c_str());
  for (int i = 0; i < frames_before; ++i) benchmark::DoNotOptimize((*source)->next({}));
  const double before = cpu_ms();
  for (auto _ : state) {
    if (const auto frame = (*source)->next({}); !frame)
      return state.SkipWithError(frame.error().what.c_str());
  }
  state.counters["cpu_ms_per_frame"] = (cpu_ms() - before) / static_cast<double>(state.iterations());
  state.counters["lost"] = static_cast<double>((*source)->counters().damaged);
}
BENCHMARK_CAPTURE(stream, simulated, "simulated:room?camera=0", 75)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);
BENCHMARK_CAPTURE(stream, fake_kinect, "freenect://BENCH1", 15)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);

void open_and_close(benchmark::State& state) {
  if (kinect().empty()) return state.SkipWithError("run benchmarks/cameras.py");
  std::ofstream(kinect()).close();
  double kb = 0, files = 0, threads = 0;
  int cycle = 0;
  for (auto _ : state) {
    const auto source = open_device("freenect://BENCH1");
    if (!source || !(*source)->next({})) return state.SkipWithError("it did not open");
    if (++cycle != 20) continue;  // what is made once has been made
    kb = resident_kb();
    files = entries("/proc/self/fd");
    threads = entries("/proc/self/task");
  }
  // The twentieth was counted while its camera was open.
  const auto source = open_device("freenect://BENCH1");
  if (!source || !(*source)->next({})) return state.SkipWithError("it did not open");
  state.counters["grown_kb"] = resident_kb() - kb;
  state.counters["grown_files"] = entries("/proc/self/fd") - files;
  state.counters["grown_threads"] = entries("/proc/self/task") - threads;
}
BENCHMARK(open_and_close)->Unit(benchmark::kMillisecond)->Iterations(1000);

// One iteration: unplugged while it streams, noticed, plugged in, the first frame. Time is from plugging in.
void unplug_and_replug(benchmark::State& state) {
  if (kinect().empty()) return state.SkipWithError("run benchmarks/cameras.py");
  std::ofstream(kinect()).close();
  const auto source = open_lasting_device("freenect://BENCH1");
  if (!source) return state.SkipWithError(source.error().what.c_str());
  using Clock = std::chrono::steady_clock;
  double worst = 0, kb = 0, files = 0, threads = 0;
  std::uint64_t last = 0;
  int cycle = 0;
  for (auto _ : state) {
    auto frame = (*source)->next({});
    if (!frame || frame->stamp.sequence != ++last) return state.SkipWithError("a frame is missing");
    if (++cycle == 20) {
      kb = resident_kb();
      files = entries("/proc/self/fd");
      threads = entries("/proc/self/task");
    }
    fs::remove(kinect());
    for (; frame; frame = (*source)->next({})) last = frame->stamp.sequence;
    std::ofstream(kinect()).close();
    const auto begin = Clock::now();
    while (!(frame = (*source)->next({}))) {
      if (Clock::now() - begin > std::chrono::seconds(5)) return state.SkipWithError("it did not come back");
    }
    last = frame->stamp.sequence;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    worst = std::max(worst, seconds);
    state.SetIterationTime(seconds);
  }
  state.counters["worst_ms"] = 1e3 * worst;
  state.counters["grown_kb"] = resident_kb() - kb;
  state.counters["grown_files"] = entries("/proc/self/fd") - files;
  state.counters["grown_threads"] = entries("/proc/self/task") - threads;
}
BENCHMARK(unplug_and_replug)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(100);

}  // namespace
}  // namespace copresence::sensor
