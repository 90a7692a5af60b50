// Measures cameras through OpenNI2. The results are the CPU time per 640x480 frame and the latency
// from the sensor to the encode thread. Other cases measure leaks, and the time until a replugged
// camera streams again. Kinects are fake (tests/support/fake_freenect). In cases named "still", the
// fake Kinect draws its pictures only once. So these cases measure the driver, OpenNI2 and the
// copies into an RgbdFrame. Run it by benchmarks/cameras.py, which sets the library path.

#include <benchmark/benchmark.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "capture_server/sensor/device_source.h"
#include "common/flow/mailbox.h"

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

// Returns the CPU time that the drivers' threads have used so far.
double driver_ms() {
  double sum = 0;
  for (const auto& thread : fs::directory_iterator("/proc/self/task")) {
    std::ifstream name_file(thread.path() / "comm"), time_file(thread.path() / "schedstat");
    std::string name;
    double ns = 0;
    name_file >> name;
    time_file >> ns;
    if (name == "kinect" || name == "simulated") sum += 1e-6 * ns;
  }
  return sum;
}

// The resources of this process: allocated and resident memory, open files and threads.
struct Holdings {
  double heap_kb = 0, resident_kb = 0, files = 0, threads = 0;

  static Holdings now() {
    const auto entries = [](const char* folder) {
      return static_cast<double>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    };
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    const auto heap = mallinfo2();
    return {static_cast<double>(heap.uordblks + heap.hblkhd) / 1024, resident * 4, entries("/proc/self/fd"),
            entries("/proc/self/task")};
  }

  void tell_growth(benchmark::State& state) const {
    const Holdings end = now();
    state.counters["grown_heap_kb"] = end.heap_kb - heap_kb;
    state.counters["grown_resident_kb"] = end.resident_kb - resident_kb;
    state.counters["grown_files"] = end.files - files;
    state.counters["grown_threads"] = end.threads - threads;
  }
};

// Returns the file of a fake Kinect, or an empty path if the fake library is not loaded.
fs::path kinect() {
  const char* bus = std::getenv("COPRESENCE_FAKE_KINECTS");
  return bus ? fs::path(bus) / "BENCH1" : fs::path();
}

// Returns whether `uri` can be opened. First plugs in a fake Kinect by writing `words` to its file.
bool plug_in(const std::string& uri, const std::string& words = "") {
  if (!uri.starts_with("freenect")) return true;
  if (kinect().empty()) return false;
  std::ofstream(kinect()) << words;
  return true;
}

void stream(benchmark::State& state, const std::string& uri, const std::string& words, int frames_before) {
  if (!plug_in(uri, words)) return state.SkipWithError("run benchmarks/cameras.py");
  const auto source = open_device(uri);
  if (!source) return state.SkipWithError(source.error().what.c_str());
  for (int i = 0; i < frames_before; ++i) benchmark::DoNotOptimize((*source)->next({}));
  const double before = cpu_ms(), driver_before = driver_ms();
  for (auto _ : state) {
    if (const auto frame = (*source)->next({}); !frame)
      return state.SkipWithError(frame.error().what.c_str());
  }
  const auto frames = static_cast<double>(state.iterations());
  state.counters["cpu_ms_per_frame"] = (cpu_ms() - before) / frames;
  state.counters["driver_ms_per_frame"] = (driver_ms() - driver_before) / frames;
  state.counters["late"] = static_cast<double>((*source)->counters().late);
}
// The first 60 frames are the first period of the animation. Other cases measure later periods.
BENCHMARK_CAPTURE(stream, simulated_first_two_seconds, "simulated:room?camera=0", "", 0)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(60);
BENCHMARK_CAPTURE(stream, simulated, "simulated:room?camera=1", "", 75)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);
BENCHMARK_CAPTURE(stream, fake_kinect, "freenect://BENCH1", "", 15)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);
BENCHMARK_CAPTURE(stream, fake_kinect_without_drawing, "freenect://BENCH1", "still", 15)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(150);

// Measures the time from the arrival of a depth picture until another thread has its frame. It
// covers pairing with colour, copying from OpenNI2's buffers, the mailbox, and waking the other
// thread, which is always waiting. Waiting for colour is not counted. A fake Kinect's colour comes
// 9 ms after depth, and the simulated camera's at the same time.
void arrival_to_encoder(benchmark::State& state, const std::string& uri) {
  if (!plug_in(uri)) return state.SkipWithError("run benchmarks/cameras.py");
  const auto source = open_device(uri);
  if (!source) return state.SkipWithError(source.error().what.c_str());
  for (int i = 0; i < 75; ++i) benchmark::DoNotOptimize((*source)->next({}));
  flow::Mailbox<RgbdFrame> mailbox;
  std::jthread capture([&](std::stop_token stop) {
    while (!stop.stop_requested()) {
      if (auto frame = (*source)->next(stop)) mailbox.put(std::move(*frame));
    }
  });
  std::vector<double> ms;
  for (auto _ : state) {
    const auto frame = mailbox.take({});
    const std::chrono::duration<double, std::milli> held =
        std::chrono::steady_clock::now() - frame->metadata.captured_at;
    ms.push_back(held.count());
  }
  std::sort(ms.begin(), ms.end());
  const auto percentile = [&](double share) {
    return ms[static_cast<std::size_t>(share * static_cast<double>(ms.size() - 1))];
  };
  state.counters["p50_ms"] = percentile(0.5);
  state.counters["p95_ms"] = percentile(0.95);
  state.counters["p99_ms"] = percentile(0.99);
}
BENCHMARK_CAPTURE(arrival_to_encoder, simulated, "simulated:room?camera=0")
    ->Unit(benchmark::kMillisecond)
    ->Iterations(300);

void open_and_close(benchmark::State& state) {
  if (kinect().empty()) return state.SkipWithError("run benchmarks/cameras.py");
  std::ofstream(kinect()).close();
  Holdings early;
  int cycle = 0;
  for (auto _ : state) {
    const auto source = open_device("freenect://BENCH1");
    if (!source || !(*source)->next({})) return state.SkipWithError("it did not open");
    if (++cycle == 20) early = Holdings::now();  // By now, all one-time allocations are done.
  }
  // The twentieth camera was still open when resources were counted.
  const auto source = open_device("freenect://BENCH1");
  if (!source || !(*source)->next({})) return state.SkipWithError("it did not open");
  early.tell_growth(state);
}
BENCHMARK(open_and_close)->Unit(benchmark::kMillisecond)->Iterations(1000);

// Measures the time from plugging in a camera until its first frame arrives. In each iteration, the
// camera is unplugged while it streams, and plugged in once the source has noticed that.
void unplug_and_replug(benchmark::State& state) {
  if (kinect().empty()) return state.SkipWithError("run benchmarks/cameras.py");
  std::ofstream(kinect()).close();
  const auto source = open_reconnecting_device("freenect://BENCH1");
  if (!source) return state.SkipWithError(source.error().what.c_str());
  using Clock = std::chrono::steady_clock;
  double worst = 0;
  Holdings early;
  std::uint64_t last = 0;
  int cycle = 0;
  for (auto _ : state) {
    auto frame = (*source)->next({});
    if (!frame || frame->metadata.sequence != ++last) return state.SkipWithError("a frame is missing");
    if (++cycle == 20) early = Holdings::now();
    fs::remove(kinect());
    for (; frame; frame = (*source)->next({})) last = frame->metadata.sequence;
    std::ofstream(kinect()).close();
    const auto begin = Clock::now();
    while (!(frame = (*source)->next({}))) {
      if (Clock::now() - begin > std::chrono::seconds(5)) return state.SkipWithError("it did not come back");
    }
    last = frame->metadata.sequence;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    worst = std::max(worst, seconds);
    state.SetIterationTime(seconds);
  }
  state.counters["worst_ms"] = 1e3 * worst;
  early.tell_growth(state);
}
BENCHMARK(unplug_and_replug)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(100);

}  // namespace
}  // namespace copresence::sensor
