#include "common/color/yuv420.h"

#include <benchmark/benchmark.h>

namespace copresence::color {
namespace {

ColorImage gradient() {
  ColorImage image(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) image(x, y) = {std::uint8_t(x), std::uint8_t(y), std::uint8_t(x ^ y)};
  }
  return image;
}

void rgb_to_yuv420_640x480(benchmark::State& state) {
  const ColorImage image = gradient();
  Picture picture;
  for (auto _ : state) {
    rgb_to_yuv420(image, picture);
    benchmark::DoNotOptimize(picture.plane8(0).data());
  }
  state.SetBytesProcessed(state.iterations() * 640 * 480 * 3);
}
BENCHMARK(rgb_to_yuv420_640x480)->Unit(benchmark::kMillisecond);

void yuv420_to_rgb_640x480(benchmark::State& state) {
  Picture picture;
  rgb_to_yuv420(gradient(), picture);
  ColorImage image;
  for (auto _ : state) {
    yuv420_to_rgb(picture, image);
    benchmark::DoNotOptimize(image.data());
  }
  state.SetBytesProcessed(state.iterations() * 640 * 480 * 3);
}
BENCHMARK(yuv420_to_rgb_640x480)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::color
