// Measures the time of the temporal filters for a 640x480 frame on one thread.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"

namespace copresence::temporal_filter {
namespace {

constexpr int kWidth = 640, kHeight = 480, kFrames = 8;

struct Depth {
  DepthImage depth{kWidth, kHeight};
  StateImage state{kWidth, kHeight, DepthState::kMeasured};
};

/// Returns frames with posts in front of a slanted wall from 2 to 3.5 m. Some depths are wrong by
/// one level, and 4 % of the pixels are changing holes. The picture moves by `shift_px` from frame
/// to frame.
std::vector<Depth> depth_frames(int shift_px) {
  std::minstd_rand random(1);
  std::uniform_int_distribution<int> level(-1, 1);
  std::bernoulli_distribution lost(0.04);
  std::vector<Depth> frames(kFrames);
  int shifted = 0;
  for (Depth& frame : frames) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const int there = (x + shifted) % kWidth;
        const double z = there % 80 < 20 ? 1.5 : 2 + 1.5 * there / kWidth;
        frame.depth(x, y) =
            static_cast<std::uint16_t>(std::lround(1000 * (z + level(random) * kKinectV1Noise.step_m(z))));
        if (!lost(random)) continue;
        frame.depth(x, y) = 0;
        frame.state(x, y) = DepthState::kHole;
      }
    }
    shifted += shift_px;
  }
  return frames;
}

std::vector<Picture> color_frames(int shift_px) {
  std::minstd_rand random(1);
  std::uniform_int_distribution<int> grain(-3, 3);
  std::vector<Picture> frames(kFrames, Picture(PixelFormat::kYuv420, kWidth, kHeight));
  int shifted = 0;
  for (Picture& frame : frames) {
    for (int plane = 0; plane < 3; ++plane) {
      int x = shifted;
      for (std::uint8_t& sample : frame.plane8(plane))
        sample = static_cast<std::uint8_t>((x++ / 8 % 2) * 60 + 90 + grain(random));
    }
    shifted += shift_px;
  }
  return frames;
}

template <class Frame, class Apply>
void run(benchmark::State& state, const std::vector<Frame>& frames, Apply apply) {
  std::size_t next = 0;
  for (auto unused : state) {
    state.PauseTiming();
    Frame frame = frames[next++ % frames.size()];
    state.ResumeTiming();
    apply(frame);
    benchmark::DoNotOptimize(frame);
  }
}

void depth_filter(benchmark::State& state) {
  DepthFilter filter(kWidth, kHeight, DepthUnit::kMillimetre, kKinectV1Noise);
  run(state, depth_frames(static_cast<int>(state.range(0))),
      [&](Depth& frame) { filter.apply(frame.depth, frame.state); });
}
BENCHMARK(depth_filter)->ArgName("shift_px")->Arg(0)->Arg(5)->Unit(benchmark::kMillisecond);

void color_filter(benchmark::State& state) {
  ColorFilter filter;
  run(state, color_frames(static_cast<int>(state.range(0))),
      [&](Picture& frame) { filter.apply(frame, false); });
}
BENCHMARK(color_filter)->ArgName("shift_px")->Arg(0)->Arg(5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::temporal_filter
