#include "simulation/sensor/frame_cache.h"

#include <gtest/gtest.h>

#include "simulation/scene/noise.h"

namespace copresence::simulation {
namespace {

constexpr int kWidth = 61, kHeight = 17;

// The background with some pixels changed, in runs at arbitrary positions.
NoiseFreeFrame changed(const NoiseFreeFrame& background, std::uint32_t seed) {
  NoiseFreeFrame frame = background;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const float value = unit(hash(seed, i));
    if (hash(seed, i / 13, 1) % 3 == 0) frame.dots.data()[i] = {value, 1 - value};
    if (hash(seed, i / 7, 2) % 4 == 0) frame.colors.data()[i].g = static_cast<std::int16_t>(1000 * value);
  }
  return frame;
}

void expect_same(const NoiseFreeFrame& a, const NoiseFreeFrame& b) {
  EXPECT_EQ(a.dots, b.dots);
  EXPECT_EQ(a.colors, b.colors);
}

TEST(FrameCache, ReturnsEachFrameAsItWasStoredInAnyOrder) {
  const NoiseFreeFrame background{DotImage(kWidth, kHeight, {300, 0.5f}),
                                  NoiseFreeColors(kWidth, kHeight, {100, 200, 300})};
  std::vector<NoiseFreeFrame> frames{background};
  for (std::uint32_t seed = 1; seed < 6; ++seed) frames.push_back(changed(background, seed));
  FrameCache cache(frames.size(), background);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_FALSE(cache.contains(i));
    cache.store(i, frames[i]);
    EXPECT_TRUE(cache.contains(i));
  }
  for (const std::size_t index : {1u, 2u, 2u, 5u, 0u, 3u, 4u, 1u, 5u})
    expect_same(cache.load(index), frames[index]);
}

TEST(FrameCache, ReplacesAFrame) {
  const NoiseFreeFrame background{DotImage(kWidth, kHeight), NoiseFreeColors(kWidth, kHeight)};
  FrameCache cache(2, background);
  cache.store(0, changed(background, 1));
  cache.store(1, changed(background, 2));
  expect_same(cache.load(0), changed(background, 1));
  cache.store(0, changed(background, 3));
  expect_same(cache.load(0), changed(background, 3));
  expect_same(cache.load(1), changed(background, 2));
}

}  // namespace
}  // namespace copresence::simulation
