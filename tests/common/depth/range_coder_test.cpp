#include "common/depth/entropy/range_coder.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  std::array<BinaryContext, 3> models;
  std::vector<std::uint8_t> buffer(list.size() * RangeEncoder::kMostBytes + RangeEncoder::kEndBytes);
  RangeEncoder encoder(buffer.data());
  for (const Decision& d : list) encoder.encode(models[d.model], d.bit);
  buffer.resize(static_cast<std::size_t>(encoder.finish() - buffer.data()));
  return buffer;
}

TEST(RangeCoder, ReadsWhatItWroteWhateverTheOdds) {
  for (const double probability : {0.0, 0.001, 0.3, 0.5, 0.9, 0.9999, 1.0}) {
    for (const int count : {0, 1, 2, 7, 100, 20000}) {
      const auto list = decisions(probability, count);
      const auto bytes = write(list);
      std::array<BinaryContext, 3> models;
      RangeDecoder decoder(bytes);
      for (const Decision& d : list)
        ASSERT_EQ(decoder.decode(models[d.model]), d.bit) << probability << ' ' << count;
    }
  }
}

TEST(RangeCoder, CarriesThroughLongRunsOfOnes) {
  // Coding the upper part again and again moves the low end towards all ones. The last decision may
  // then cause a carry.
  for (int run = 1; run < 400; ++run) {
    BinaryContext zeros;
    std::vector<std::uint8_t> bytes(1000);
    RangeEncoder encoder(bytes.data());
    for (int i = 0; i < run; ++i) encoder.encode(zeros, false);
    BinaryContext other;
    for (int i = 0; i < 9; ++i) encoder.encode(other, i % 2 == 0);
    bytes.resize(static_cast<std::size_t>(encoder.finish() - bytes.data()));
    BinaryContext zeros_again, other_again;
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

TEST(RangeCoder, ReadsOnWhereItsBytesEnd) {
  const std::vector<Decision> list(3000, {0, false});
  std::vector<std::uint8_t> bytes = write(list);
  while (!bytes.empty() && bytes.back() == 0) bytes.pop_back();
  BinaryContext model;
  RangeDecoder decoder(bytes);
  for (const Decision& d : list) ASSERT_EQ(decoder.decode(model), d.bit);
}

TEST(RangeCoder, GoesOnInALargerRoom) {
  const auto list = decisions(0.3, 4000);
  std::array<BinaryContext, 3> models;
  std::vector<std::uint8_t> buffer(5000), larger(10000);
  RangeEncoder encoder(buffer.data());
  for (std::size_t i = 0; i < list.size(); ++i) {
    encoder.encode(models[list[i].model], list[i].bit);
    if (i != 2000) continue;
    const auto used = encoder.next() - buffer.data();
    std::copy_n(buffer.begin(), used, larger.begin());
    encoder.move_to(larger.data() + used);
  }
  larger.resize(static_cast<std::size_t>(encoder.finish() - larger.data()));
  EXPECT_EQ(larger, write(list));
}

}  // namespace
}  // namespace copresence::depth
