// Measures the registration of a 640x480 depth frame to colour of another viewpoint and size.

#include <benchmark/benchmark.h>

#include "capture_server/registration/registration.h"

namespace copresence::registration {
namespace {

void unregistered(benchmark::State& state, int color_width, int color_height) {
  const CameraModel depth = camera_from_field_of_view(640, 480, 1.0, 0.77);
  const CameraModel color = camera_from_field_of_view(color_width, color_height, 1.09, 0.85);
  const Rigid3 color_from_depth{Eigen::Matrix3d::Identity(), {-0.025, 0, 0}};
  auto registration =
      Registration::open({depth, color, color_from_depth, DepthUnit::kMillimetre, false}).value();
  RgbdFrame frame;
  frame.depth = DepthImage(640, 480);
  frame.state = StateImage(640, 480, DepthState::kMeasured);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const bool near = (x / 80 + y / 80) % 2 == 0;
      frame.depth(x, y) = static_cast<std::uint16_t>(near ? 1000 + x : 3000 - y);
      if (x % 80 < 8) frame.depth(x, y) = 0, frame.state(x, y) = DepthState::kHole;
    }
  }
  const ColorImage taken(color_width, color_height, {90, 100, 110});
  for (auto _ : state) {
    frame.color = taken;
    frame = registration.apply(std::move(frame));
    benchmark::DoNotOptimize(frame.color.value().data());
  }
  state.SetBytesProcessed(state.iterations() * (640 * 480 * 3 + color_width * color_height * 3));
}

BENCHMARK_CAPTURE(unregistered, color_640x480, 640, 480)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(unregistered, color_1280x960, 1280, 960)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::registration
