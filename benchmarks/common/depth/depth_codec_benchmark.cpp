// Measures encoding and decoding of every depth codec, in milliseconds per 640x480 frame, without
// video coding. The validity mask is also measured alone.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "common/depth/depth_codec.h"
#include "common/depth/mask/validity_mask.h"
#include "tests/common/depth/scenes.h"

namespace copresence::depth {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr std::int64_t kBytes = std::int64_t{kWidth} * kHeight * 2;

const std::vector<testing::Scene>& scenes() {
  static const std::vector<testing::Scene> list = [] {
    std::vector<testing::Scene> made;
    for (int time = 0; time < 8; ++time) made.push_back(testing::kinect_scene(kWidth, kHeight, time));
    return made;
  }();
  return list;
}

void encode_depth(benchmark::State& state, std::string_view codec) {
  Encoder encoder = *Encoder::open(codec, {kWidth, kHeight, DepthUnit::kMillimetre, {}});
  std::size_t i = 0;
  for (auto _ : state) {
    const testing::Scene& scene = scenes()[i++ % scenes().size()];
    benchmark::DoNotOptimize(encoder.encode(scene.depth, scene.state, false));
  }
  state.SetBytesProcessed(state.iterations() * kBytes);
}

void decode_depth(benchmark::State& state, std::string_view codec) {
  const DepthFormat format{kWidth, kHeight, DepthUnit::kMillimetre, {}};
  Encoder encoder = *Encoder::open(codec, format);
  Decoder decoder = *Decoder::open(encoder.description(), format);
  DepthImage depth;
  StateImage states;
  std::size_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const testing::Scene& scene = scenes()[i++ % scenes().size()];
    const PlanarDepth planes = *encoder.encode(scene.depth, scene.state, false);
    state.ResumeTiming();
    if (!decoder.decode(planes, depth, states)) state.SkipWithError("a frame did not decode");
  }
  state.SetBytesProcessed(state.iterations() * kBytes);
}

void encode_mask(benchmark::State& state) {
  ValidityMaskEncoder encoder(kWidth, kHeight);
  std::vector<std::uint8_t> bytes;
  std::size_t i = 0;
  for (auto _ : state) {
    bytes.clear();
    encoder.encode(scenes()[i % scenes().size()].state, i == 0, bytes);
    ++i;
  }
  state.SetBytesProcessed(state.iterations() * kBytes);
}

void decode_mask(benchmark::State& state) {
  ValidityMaskEncoder encoder(kWidth, kHeight);
  ValidityMaskDecoder decoder(kWidth, kHeight);
  std::vector<std::uint8_t> bytes;
  StateImage states;
  std::size_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    bytes.clear();
    encoder.encode(scenes()[i % scenes().size()].state, i == 0, bytes);
    state.ResumeTiming();
    decoder.decode(bytes, i == 0, states);
    ++i;
  }
  state.SetBytesProcessed(state.iterations() * kBytes);
}

const bool kRegistered = [] {
  for (const std::string_view name : codec_names()) {
    const std::string suffix(name);
    benchmark::RegisterBenchmark(("encode/" + suffix).c_str(), encode_depth, name)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("decode/" + suffix).c_str(), decode_depth, name)
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("encode_mask", encode_mask)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("decode_mask", decode_mask)->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
}  // namespace copresence::depth
