#include "common/depth/levels/codebook.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "tests/common/depth/scenes.h"

namespace copresence::depth {
namespace {

constexpr DepthRangeUnits kRange{400, 5000};

Codebook empty_table() {
  return {kRange, DepthUnit::kMillimetre, kKinectV1Noise};
}

void assign(Codebook& table, const std::vector<std::uint16_t>& levels) {
  table.assign(levels, table.sensor_spacing(levels));
}

std::vector<std::uint16_t> kinect_levels() {
  std::vector<std::uint16_t> levels;
  for (int disparity = 878; disparity >= 71; --disparity) {
    const auto level = static_cast<std::uint16_t>(std::lround(351300.0 / disparity));
    if (kRange.contains(level) && (levels.empty() || level > levels.back())) levels.push_back(level);
  }
  return levels;
}

std::vector<std::uint16_t> present(const Codebook& table) {
  std::vector<std::uint16_t> levels(table.levels().begin(), table.levels().end());
  std::erase(levels, 0);
  return levels;
}

int code_of(const Codebook& table, std::uint16_t level) {
  const auto levels = table.levels();
  return static_cast<int>(std::find(levels.begin(), levels.end(), level) - levels.begin());
}

TEST(Codebook, HoldsEveryLevelOfAKinectWithRoomToSpare) {
  Codebook table = empty_table();
  const auto levels = kinect_levels();
  assign(table, levels);
  EXPECT_EQ(present(table), levels);
  EXPECT_LT(table.count(), 900);
}

TEST(Codebook, LeavesRoomForLevelsNotYetSeen) {
  const auto all = kinect_levels();
  std::vector<std::uint16_t> seen, late;
  for (std::size_t i = 0; i < all.size(); ++i) (i % 7 == 3 ? late : seen).push_back(all[i]);
  Codebook table = empty_table();
  assign(table, seen);
  const Codebook before = table;
  std::shuffle(late.begin(), late.end(), std::minstd_rand(3));
  for (const std::uint16_t level : late) ASSERT_TRUE(table.insert(level));
  EXPECT_EQ(present(table), all);
  int moved = 0;
  for (const std::uint16_t level : seen) moved += code_of(before, level) != code_of(table, level);
  EXPECT_LT(moved, static_cast<int>(seen.size()) / 4);
}

TEST(Codebook, TakesLevelsUntilEveryCodeIsTakenAndKeepsThemSorted) {
  Codebook table({1, 65535}, DepthUnit::k100Micrometres, kKinectV1Noise);
  std::vector<std::uint16_t> levels(65535);
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<std::uint16_t>(i + 1);
  std::shuffle(levels.begin(), levels.end(), std::minstd_rand(5));
  for (int i = 0; i < Codebook::kCodes; ++i) ASSERT_TRUE(table.insert(levels[i])) << i;
  EXPECT_FALSE(table.insert(levels[Codebook::kCodes]));
  EXPECT_EQ(table.count(), Codebook::kCodes);
  std::sort(levels.begin(), levels.begin() + Codebook::kCodes);
  EXPECT_TRUE(std::equal(table.levels().begin(), table.levels().end(), levels.begin()));
}

TEST(Codebook, SpacesMoreLevelsThanAKinectHasWithoutLosingOne) {
  std::vector<std::uint16_t> levels;
  for (int z = 3000; z < 3000 + 1024; ++z) levels.push_back(static_cast<std::uint16_t>(z));
  Codebook table = empty_table();
  assign(table, levels);
  EXPECT_EQ(present(table), levels);
}

TEST(LevelSpacing, SpendsTheCodesOnTheDepthsThatTheSceneHas) {
  const auto levels = kinect_levels();
  std::vector<std::uint32_t> pixels(levels.size(), 0);
  for (std::size_t i = 0; i < levels.size(); ++i) pixels[i] = levels[i] > 1000 && levels[i] < 1500 ? 100 : 0;
  Codebook table = empty_table();
  const auto distance = table.scene_spacing(levels, pixels);
  table.assign(levels, distance);
  EXPECT_EQ(present(table), levels);
  const auto at = [&](int z) { return *std::lower_bound(levels.begin(), levels.end(), z); };
  const int scene = code_of(table, at(1400)) - code_of(table, at(1100));
  EXPECT_GE(scene, 2 * 351.3 * (1 / 1.1 - 1 / 1.4));
  const int elsewhere = code_of(table, at(4000)) - code_of(table, at(2000));
  EXPECT_NEAR(elsewhere, 351.3 * (1 / 2.0 - 1 / 4.0), 4);
}

TEST(LevelSpacing, IsEvenInInverseDepthOverTheWholeRange) {
  const auto levels = kinect_levels();
  Codebook table = empty_table();
  table.assign(levels, table.even_spacing(levels));
  EXPECT_EQ(present(table), levels);
  const double steps = 351300.0 / kRange.near - 351300.0 / kRange.far;
  for (const std::uint16_t level : levels) {
    ASSERT_NEAR(code_of(table, level), 1023 * (351300.0 / kRange.near - 351300.0 / level) / steps, 2);
  }
}

TEST(LevelSpacing, GivesTwoCodesToEveryStepBeyondTheNearestAlsoToLaterLevels) {
  const auto all = kinect_levels();
  Codebook table = empty_table();
  const double nearest = table.nearest_double();
  EXPECT_NEAR(nearest, 625, 5) << "two codes per step need half a metre less than the whole range";
  std::vector<std::uint16_t> far, later;
  for (const std::uint16_t level : all) {
    if (level > nearest) (level > 2000 ? far : later).push_back(level);
  }
  table.assign(far, table.double_spacing(far));
  std::shuffle(later.begin(), later.end(), std::minstd_rand(3));
  for (const std::uint16_t level : later) ASSERT_TRUE(table.insert(level));
  const auto levels = present(table);
  for (const std::uint16_t level : levels) {
    const double steps = 351300.0 / level - 351300.0 / levels.back();
    ASSERT_NEAR(code_of(table, levels.back()) - code_of(table, level), 2 * steps, 4) << level;
  }
}

TEST(LevelSpacing, AscendsAndTravelsWhateverTheScene) {
  std::minstd_rand random(17);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint16_t> levels;
    std::vector<std::uint32_t> pixels;
    for (const std::uint16_t level : kinect_levels()) {
      if (random() % 100 < static_cast<unsigned>(i)) levels.push_back(level);
    }
    for (std::size_t k = 0; k < levels.size(); ++k)
      pixels.push_back(static_cast<std::uint32_t>(random() % 5000));
    Codebook table = empty_table();
    for (const auto& distance :
         {table.scene_spacing(levels, pixels), table.double_spacing(levels), table.even_spacing(levels)}) {
      table.assign(levels, distance);
      ASSERT_EQ(present(table), levels);
      const auto depth = table.depth_of_code();
      ASSERT_TRUE(std::is_sorted(depth.begin(), depth.end()));
      Codebook received = empty_table();
      std::vector<std::uint8_t> bytes;
      table.write_change(empty_table(), bytes);
      ASSERT_TRUE(received.read_change(bytes));
      ASSERT_TRUE(std::equal(table.levels().begin(), table.levels().end(), received.levels().begin()));
    }
  }
}

TEST(Codebook, StandsForDepthThatAscendsWithTheCode) {
  Codebook table = empty_table();
  EXPECT_EQ(table.depth_of_code().size(), 1024u);
  assign(table, kinect_levels());
  auto depth = table.depth_of_code();
  EXPECT_TRUE(std::is_sorted(depth.begin(), depth.end()));
  assign(table, {1000, 1500});
  depth = table.depth_of_code();
  EXPECT_TRUE(std::is_sorted(depth.begin(), depth.end()));
  EXPECT_EQ(depth.front(), 1000);
  EXPECT_EQ(depth.back(), 1500);
  // From 1000 to 1500 mm, a Kinect has 117 steps. The middle in 1/z is 1200 mm.
  EXPECT_NEAR(depth[(code_of(table, 1000) + code_of(table, 1500)) / 2], 1200, 3);
}

TEST(Codebook, EvenLevelsAreEvenInInverseDepth) {
  Codebook table = empty_table();
  table.assign_evenly(kRange);
  const auto levels = present(table);
  EXPECT_EQ(levels.front(), 400);
  EXPECT_EQ(levels.back(), 5000);
  EXPECT_TRUE(std::is_sorted(levels.begin(), levels.end()));
}

TEST(Codebook, ChangesTravel) {
  Codebook sent = empty_table(), received = empty_table();
  std::minstd_rand random(11);
  for (int i = 0; i < 200; ++i) {
    const Codebook earlier = sent;
    for (int k = 0; k < 4; ++k) {
      const auto level = static_cast<std::uint16_t>(400 + random() % 4601);
      const auto levels = sent.levels();
      if (std::find(levels.begin(), levels.end(), level) == levels.end()) sent.insert(level);
    }
    std::vector<std::uint8_t> bytes;
    sent.write_change(earlier, bytes);
    ASSERT_TRUE(received.read_change(bytes));
    ASSERT_TRUE(std::equal(sent.levels().begin(), sent.levels().end(), received.levels().begin()));
  }
}

TEST(Codebook, HasTheFormatThatIsDocumented) {
  Codebook table = empty_table();
  assign(table, {400, 405, 411, 500});
  std::vector<std::uint8_t> bytes;
  table.write_change(empty_table(), bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0x3f, 0x07, 0xa5, 0x0c, 0x99, 0x23, 0x04}));
  const Codebook same = table;
  bytes.clear();
  table.write_change(same, bytes);
  EXPECT_TRUE(bytes.empty());
}

TEST(Codebook, TakesHalfAByteForALevelThatTheOthersForetell) {
  Codebook table = empty_table();
  assign(table, kinect_levels());
  std::vector<std::uint8_t> bytes;
  table.write_change(empty_table(), bytes);
  EXPECT_LT(bytes.size(), kinect_levels().size() / 2);
}

TEST(Codebook, RefusesBytesThatMakeNoTableAndStaysAsItWas) {
  Codebook table = empty_table();
  assign(table, {500, 600});
  const std::vector<std::uint16_t> before(table.levels().begin(), table.levels().end());
  std::minstd_rand random(7);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> bytes(1 + random() % 24);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 8);
    Codebook read = table;
    const auto done = read.read_change(bytes);
    const auto levels = present(read);
    ASSERT_TRUE(std::is_sorted(levels.begin(), levels.end(), std::less_equal<>()) &&
                kRange.contains(levels.front()) && kRange.contains(levels.back()));
    if (done) continue;
    ++refused;
    ASSERT_EQ(done.error().code, ErrorCode::kCorrupt);
    ASSERT_TRUE(std::equal(before.begin(), before.end(), read.levels().begin()));
  }
  EXPECT_GT(refused, 500);
}

TEST(Codebook, RefusesLevelsThatDoNotAscendOrLieOutsideTheRange) {
  const auto code_3 = [](std::uint16_t level) {
    Codebook table = empty_table();
    table.assign(std::vector{level}, std::vector<double>{3});
    std::vector<std::uint8_t> bytes;
    table.write_change(empty_table(), bytes);
    return bytes;
  };
  Codebook table = empty_table();
  assign(table, {400, 4000});
  EXPECT_TRUE(Codebook(table).read_change(code_3(405)));
  EXPECT_FALSE(Codebook(table).read_change(code_3(4500)));  // The level 4500 precedes 4000.
  EXPECT_FALSE(Codebook({400, 449}, DepthUnit::kMillimetre, kKinectV1Noise).read_change(code_3(450)));
}

}  // namespace
}  // namespace copresence::depth
