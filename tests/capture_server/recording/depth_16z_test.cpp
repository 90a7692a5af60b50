#include "capture_server/recording/depth_16z.h"

#include <gtest/gtest.h>

#include <random>

namespace copresence::recording {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes coded(const DepthImage& depth) {
  Bytes bytes;
  const auto done = append_depth_16z(depth, bytes);
  EXPECT_TRUE(done);
  return bytes;
}

DepthImage of_values(std::initializer_list<int> values) {
  DepthImage depth(static_cast<int>(values.size()), 1);
  int x = 0;
  for (const int value : values) depth(x++, 0) = static_cast<std::uint16_t>(value);
  return depth;
}

DepthImage noise(int width, int height, int largest, unsigned seed) {
  DepthImage depth(width, height);
  std::mt19937 random(seed);
  for (auto& value : depth.pixels())
    value = static_cast<std::uint16_t>(random() % static_cast<unsigned>(largest + 1));
  return depth;
}

TEST(Depth16z, LooksAsDocumented) {
  EXPECT_EQ(coded(of_values({5, 5, 5})), (Bytes{1, 0, 5, 0, 0, 0, 0xE1}));             // one byte 0x66
  EXPECT_EQ(coded(of_values({0, 700, 0})), (Bytes{2, 0, 0, 0, 0xBC, 2, 0, 0, 0x57}));  // -1, then +1
  EXPECT_EQ(coded(of_values({0, 700})), (Bytes{2, 0, 0, 0, 0xBC, 2, 0, 0, 0x5D}));     // closed with 0xD
}

TEST(Depth16z, ComesBackWhateverThePicture) {
  std::vector<DepthImage> pictures{DepthImage(640, 480), DepthImage(1, 1, 9), of_values({1, 2}),
                                   of_values({3, 3, 3, 3})};
  for (const int largest : {1, 7, 12, 60, 70, 130, 700, 32766})
    pictures.push_back(noise(61, 37, largest, 5u));
  DepthImage ramp(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x)
      ramp(x, y) = static_cast<std::uint16_t>(500 + x / 3 + (y % 60) * (x % 2) * 8);
  }
  pictures.push_back(ramp);
  for (const DepthImage& picture : pictures) {
    DepthImage back(picture.width(), picture.height());
    const auto done = expand_depth_16z(coded(picture), DepthTable::kEmbedded, back);
    ASSERT_TRUE(done) << done.error().what;
    EXPECT_EQ(back, picture);
  }
}

TEST(Depth16z, ExpandsDepthsWithoutATable) {
  // The depth 700, two equal pixels, +1 and -1, a byte's difference, a whole depth.
  const Bytes bytes{0xBC, 2, 0xE1, 0x57, 0xFF, 192 - 20, 0xFF, 9, 0xC4};
  DepthImage back(7, 1);
  const auto done = expand_depth_16z(bytes, DepthTable::kNone, back);
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_EQ(back, of_values({700, 700, 700, 701, 700, 720, 2500}));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(expand_depth_16z(std::span(bytes).first(size), DepthTable::kNone, back)) << size;
}

TEST(Depth16z, RefusesMoreLevelsThanItCanNumber) {
  DepthImage depth(256, 256);
  for (int i = 0; i < 65536; ++i) depth.data()[i] = static_cast<std::uint16_t>(i);
  Bytes bytes;
  const auto done = append_depth_16z(depth, bytes);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kUnsupported);
}

TEST(Depth16z, RefusesEveryTruncation) {
  const DepthImage picture = noise(20, 10, 100, 3u);
  const Bytes whole = coded(picture);
  DepthImage back(20, 10);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(expand_depth_16z(std::span(whole).first(size), DepthTable::kEmbedded, back)) << size;
  }
}

TEST(Depth16z, SurvivesFlippedBits) {
  const Bytes whole = coded(noise(20, 10, 100, 4u));
  DepthImage back(20, 10);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = whole;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ 1 << bit);
      if (const auto done = expand_depth_16z(damaged, DepthTable::kEmbedded, back); !done) {
        EXPECT_EQ(done.error().code, ErrorCode::kCorrupt);
      }
    }
  }
}

}  // namespace
}  // namespace copresence::recording
