#include "common/depth/range_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace copresence::depth {
namespace {

struct Decision {
  int model;
  bool bit;
};

std::vector<Decision> decisions(double probability, int count) {
  std::mt19937 random(42);
  std::vector<Decision> list;
  for (int i = 0; i < count; ++i) {
    const int model = static_cast<int>(random() % 3);
    list.push_back(
        {model, std::uniform_real_distribution<>(0, 1)(random) < (model == 0 ? 0.5 : probability)});
  }
  return list;
}

std::vector<std::uint8_t> write(const std::vector<Decision>& list) {
  std::array<AdaptiveBit, 3> models;
  RangeEncoder encoder;
  for (const Decision& d : list) encoder.encode(models[d.model], d.bit);
  std::vector<std::uint8_t> bytes;
  encoder.finish(bytes);
  return bytes;
}

TEST(RangeCoder, ReadsWhatItWroteWhateverTheOdds) {
  for (const double probability : {0.0, 0.001, 0.3, 0.5, 0.9, 0.9999, 1.0}) {
    for (const int count : {0, 1, 2, 7, 100, 20000}) {
      const auto list = decisions(probability, count);
      const auto bytes = write(list);
      std::array<AdaptiveBit, 3> models;
      RangeDecoder decoder(bytes);
      for (const Decision& d : list)
        ASSERT_EQ(decoder.decode(models[d.model]), d.bit) << probability << ' ' << count;
    }
  }
}

TEST(RangeCoder, CarriesThroughLongRunsOfOnes) {
  // Choosing the upper part again and again drives the low end towards all ones; one last choice may carry
  // through.
  for (int run = 1; run < 400; ++run) {
    AdaptiveBit zeros;
    RangeEncoder encoder;
    for (int i = 0; i < run; ++i) encoder.encode(zeros, false);
    AdaptiveBit other;
    for (int i = 0; i < 9; ++i) encoder.encode(other, i % 2 == 0);
    std::vector<std::uint8_t> bytes;
    encoder.finish(bytes);
    AdaptiveBit zeros_again, other_again;
    RangeDecoder decoder(bytes);
    for (int i = 0; i < run; ++i) ASSERT_FALSE(decoder.decode(zeros_again));
    for (int i = 0; i < 9; ++i) ASSERT_EQ(decoder.decode(other_again), i % 2 == 0);
  }
}

TEST(RangeCoder, WritesNearTheEntropy) {
  const int count = 50000;
  const double p = 0.05, entropy = -p * std::log2(p) - (1 - p) * std::log2(1 - p);
  const double bits = static_cast<double>(write(decisions(p, count)).size()) * 8;
  EXPECT_LT(bits, count * (1.0 + 2 * entropy) / 3 * 1.02);
}

TEST(RangeCoder, CanBeUsedAgainAfterFinishing) {
  RangeEncoder encoder;
  std::vector<std::uint8_t> first, second;
  for (auto* bytes : {&first, &second}) {
    AdaptiveBit model;
    for (int i = 0; i < 100; ++i) encoder.encode(model, i % 3 == 0);
    encoder.finish(*bytes);
  }
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace copresence::depth
