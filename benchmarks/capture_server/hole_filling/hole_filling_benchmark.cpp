// Measures hole filling in milliseconds per 640x480 frame on one core, with 4 % and 25 % holes. The
// holes are speckle and occlusion shadows like those of a Kinect.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {
namespace {

constexpr int kWidth = 640, kHeight = 480;

/// Returns a frame of a slanted wall 2 to 4 m away. Boards at 1.2 m cast occlusion shadows on the
/// wall, and speckle is everywhere.
RgbdFrame frame_with_holes(bool many, bool color) {
  const int every = many ? 128 : 320, shadow = many ? 26 : 12, rarity = many ? 22 : 70;
  RgbdFrame frame;
  frame.depth = DepthImage(kWidth, kHeight);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  if (color) frame.color = ColorImage(kWidth, kHeight);
  unsigned random = 1;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      random = random * 1664525u + 1013904223u;
      const int in_period = x % every;
      const bool board = in_period >= every / 2 && in_period < every * 3 / 4 && y > 40;
      const bool in_shadow = in_period >= every / 2 - shadow && in_period < every / 2 && y > 40;
      const unsigned blob =
          (static_cast<unsigned>(x / 3) * 73856093u ^ static_cast<unsigned>(y / 3) * 19349663u) >> 6;
      const double z = board ? 1.2 : 1 / (0.5 - 0.0003 * x - 0.0001 * y);
      const double noise = (static_cast<double>(random >> 16 & 255u) / 255 - 0.5) * kKinectV1Noise.step_m(z);
      frame.depth(x, y) = static_cast<std::uint16_t>((z + noise) * 1000);
      if (in_shadow || blob % static_cast<unsigned>(rarity) == 0) {
        frame.depth(x, y) = 0;
        frame.state(x, y) = DepthState::kHole;
      }
      if (color) {
        const auto light = static_cast<std::uint8_t>(random >> 28);
        (*frame.color)(x, y) =
            board ? Rgb8{static_cast<std::uint8_t>(180 + light), 60, 60} : Rgb8{90, 110, light};
      }
    }
  }
  return frame;
}

void fill(benchmark::State& state, Method method, Compute compute, bool many, bool color) {
  const RgbdFrame frame = frame_with_holes(many, color);
  auto filler = open(method, compute, {kWidth, kHeight, DepthUnit::kMillimetre, {}});
  if (!filler) {
    state.SkipWithError(filler.error().what.c_str());
    return;
  }
  RgbdFrame filled = frame;
  for (auto _ : state) {
    std::copy(frame.depth.pixels().begin(), frame.depth.pixels().end(), filled.depth.pixels().begin());
    std::copy(frame.state.pixels().begin(), frame.state.pixels().end(), filled.state.pixels().begin());
    if (auto done = (*filler)->fill(filled); !done) state.SkipWithError(done.error().what.c_str());
    benchmark::DoNotOptimize(filled.depth.data());
  }
  const auto percent = [&](const RgbdFrame& of, DepthState what) {
    return 100.0 * static_cast<double>(std::count(of.state.pixels().begin(), of.state.pixels().end(), what)) /
           (kWidth * kHeight);
  };
  state.counters["holes_percent"] = percent(frame, DepthState::kHole);
  state.counters["left_percent"] = percent(filled, DepthState::kHole);
  state.SetBytesProcessed(state.iterations() * kWidth * kHeight * (color ? 5 : 2));
}

void add(const std::string& name, Method method, Compute compute) {
  for (const bool many : {false, true}) {
    for (const bool color : {true, false}) {
      const std::string full =
          name + (many ? "/many_holes" : "/few_holes") + (color ? "/color" : "/colorless");
      benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& state) {
        fill(state, method, compute, many, color);
      })->Unit(benchmark::kMillisecond);
    }
  }
}

const bool added = [] {
  add("joint", Method::kJoint, Compute::kCpu);
  add("joint_gl", Method::kJoint, Compute::kGl);
  add("bilateral", Method::kBilateral, Compute::kCpu);
  add("median", Method::kMedian, Compute::kCpu);
  return true;
}();

}  // namespace
}  // namespace copresence::hole_filling
