// What cameras cost through OpenNI2: the process's CPU time per 640x480 frame with everything that runs for it, how soon a
// frame is in the encode thread's hands, what opening and closing leaves behind, and how soon an unplugged camera goes on.
// Kinects are fake (tests/support/fake_freenect). With "still" their pictures are drawn once: what remains is the driver,
// OpenNI2 and the copies into an RgbdFrame, but nothing of libfreenect's own unpacking.
//
// benchmarks/cameras.py runs it with the fake library found first.

#include <benchmark/benchmark.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "capture_server/sensor/frame_source.h"
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

// CPU time so far of the threads in which drivers work.
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

// What this process holds: memory in use (what was freed is free, whether or not the system has it back), resident memory,
// open files and threads.
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

// A fake Kinect's file; empty where the fake library is not in place.
fs::path kinect() {
  const char* bus = std::getenv("COPRESENCE_FAKE_KINECTS");
  return bus ? fs::path(bus) / "BENCH1" : fs::path();
}

// Whether `uri` can be opened; a fake Kinect is plugged in for it, with `words` in its file.
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
// The first 60 frames are the first period of what moves, from opening on; then another camera's later ones.
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

// From the instant at which this process holds a depth picture to that at which another thread holds the frame made of it:
// pairing with colour, copying both out of OpenNI2's buffers, the mailbox, waking up. The threads are the pipeline's, with
// an encoder that is always ready. A frame waits for colour that comes later: the fake Kinect's comes 9 ms after depth, so its
// wait is not counted; of the simulated camera both come at once.
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
    if (++cycle == 20) early = Holdings::now();  // what is made once has been made
  }
  // The twentieth was counted while its camera was open.
  const auto source = open_device("freenect://BENCH1");
  if (!source || !(*source)->next({})) return state.SkipWithError("it did not open");
  early.tell_growth(state);
}
BENCHMARK(open_and_close)->Unit(benchmark::kMillisecond)->Iterations(1000);

// One iteration: unplugged while it streams, noticed, plugged in, the first frame. Time is from plugging in.
void unplug_and_replug(benchmark::State& state) {
  if (kinect().empty()) return state.SkipWithError("run benchmarks/cameras.py");
  std::ofstream(kinect()).close();
  const auto source = open_lasting_device("freenect://BENCH1");
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
