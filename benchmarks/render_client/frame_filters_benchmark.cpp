// Measures what the client does to a decoded frame before it becomes a mesh, on one thread. Each
// iteration gets a new 640x480 frame with the noise of a Kinect.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "render_client/background_memory/background_memory.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/decoding/silhouette_colors.h"
#include "render_client/moving_surfaces/moving_surfaces.h"

namespace copresence::decoding {
namespace {

constexpr int kWidth = 640, kHeight = 480, kFrames = 8;

/// Returns frames of a slanted wall from 1.5 to 3.5 m. Some depths are wrong by one level, 4 % of
/// the pixels are changing holes, and the colours have grain.
std::vector<RgbdFrame> noisy_frames() {
  std::minstd_rand random(1);
  std::uniform_int_distribution<int> level(-1, 1), grain(-3, 3);
  std::bernoulli_distribution lost(0.04);
  std::vector<RgbdFrame> frames(kFrames);
  for (RgbdFrame& frame : frames) {
    frame.depth = DepthImage(kWidth, kHeight);
    frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
    frame.color = ColorImage(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double z = 1.5 + 2.0 * x / kWidth;
        frame.depth(x, y) = static_cast<std::uint16_t>(1000 * (z + level(random) * kKinectV1Noise.step_m(z)));
        const auto gray = static_cast<std::uint8_t>((x ^ y) % 200 + 10 + grain(random));
        (*frame.color)(x, y) = {gray, gray, gray};
        if (!lost(random)) continue;
        frame.depth(x, y) = 0;
        frame.state(x, y) = DepthState::kHole;
      }
    }
  }
  return frames;
}

template <class Filter>
void run(benchmark::State& state, const std::vector<RgbdFrame>& frames, Filter filter) {
  std::size_t next = 0;
  for (auto unused : state) {
    state.PauseTiming();
    RgbdFrame frame = frames[next++ % frames.size()];
    state.ResumeTiming();
    filter(frame);
    benchmark::DoNotOptimize(frame.depth.data());
  }
}

void depth_smoothing(benchmark::State& state) {
  DepthSmoothing smoothing;
  run(state, noisy_frames(),
      [&](RgbdFrame& frame) { smoothing.smooth(frame.depth, DepthUnit::kMillimetre, kKinectV1Noise); });
}
BENCHMARK(depth_smoothing)->Unit(benchmark::kMillisecond);

// A box moves before the wall, so that its remembered part must be drawn anew.
void background_memory(benchmark::State& state) {
  std::vector<RgbdFrame> frames = noisy_frames();
  background_memory::BackgroundMemory memory;
  memory.begin(DepthUnit::kMillimetre, kKinectV1Noise);
  for (int i = 0; i < 30; ++i) memory.learn(frames[i % kFrames]);
  for (int i = 0; i < kFrames; ++i) {
    const int left = 150 + static_cast<int>(state.range(0)) * i;
    for (int y = 100; y < 400; ++y) std::fill_n(&frames[i].depth(left, y), 150, std::uint16_t{1000});
  }
  run(state, frames, [&](RgbdFrame& frame) { memory.learn(frame); });
}
BENCHMARK(background_memory)->ArgName("motion_px")->Arg(0)->Arg(20)->Unit(benchmark::kMillisecond);

// A box moves before the wall.
void motion_detector(benchmark::State& state) {
  std::vector<RgbdFrame> frames = noisy_frames();
  for (int i = 0; i < kFrames; ++i) {
    for (int y = 100; y < 400; ++y) std::fill_n(&frames[i].depth(150 + 20 * i, y), 150, std::uint16_t{1000});
  }
  moving_surfaces::MotionDetector detector;
  detector.begin(DepthUnit::kMillimetre, kKinectV1Noise);
  run(state, frames,
      [&](RgbdFrame& frame) { benchmark::DoNotOptimize(detector.detect(frame.depth).data()); });
}
BENCHMARK(motion_detector)->Unit(benchmark::kMillisecond);

// Two cameras with the same picture. A sixth of it moves, and one camera leaves that out.
void moving_surfaces(benchmark::State& state) {
  const std::vector<RgbdFrame> frames = noisy_frames();
  moving_surfaces::MovingBlocks moving(kWidth / 8, kHeight / 8);
  for (int j = 12; j < 50; ++j) std::fill_n(&moving(20, j), 20, std::uint8_t{1});
  moving_surfaces::CameraMotion motion;
  motion.moving = &moving;
  motion.view.model = {kWidth, kHeight, 585, 585, 320, 240, {}};
  std::vector<std::optional<moving_surfaces::CameraMotion>> motions(2, motion);
  motions[0]->view.frame = &frames[0];
  moving_surfaces::MovingSurfaces surfaces(2);
  run(state, frames, [&](RgbdFrame& frame) {
    motions[1]->view.frame = &frame;
    surfaces.leave_out(frame, 1, motions);
  });
}
BENCHMARK(moving_surfaces)->Unit(benchmark::kMillisecond);

/// Posts of 40 pixels in a brighter colour stand in front of the wall.
void silhouette_colors(benchmark::State& state) {
  std::vector<RgbdFrame> frames = noisy_frames();
  for (RgbdFrame& frame : frames) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (x / 40 % 2 == 0) continue;
        frame.depth(x, y) = static_cast<std::uint16_t>(frame.depth(x, y) / 2);
        (*frame.color)(x, y) = {240, 240, 240};
      }
    }
  }
  SilhouetteColors colors;
  run(state, frames, [&](RgbdFrame& frame) { colors.apply(frame, DepthUnit::kMillimetre, kKinectV1Noise); });
}
BENCHMARK(silhouette_colors)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::decoding
