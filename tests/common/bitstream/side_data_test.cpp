#include "common/bitstream/side_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/frame/bounds.h"

namespace copresence::bitstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kDepth = {0, 0, 0,    1, 0x67, 0x11, 0,    0, 0, 1, 0x68, 0x22, 0,
                      0, 1, 0x06, 5, 1,    9,    0x80, 0, 0, 1, 0x65, 0x33, 0x44};
const Bytes kColor = {0, 0, 0, 1, 0x61, 0x55, 0x66};

SideData example() {
  SideData data;
  data.sequence = 0x0102030405060708;
  data.previous = 0x0102030405060707;
  data.captured_at = Instant(std::chrono::seconds(1));
  data.qp = 24;
  data.has_color = true;
  data.table = {0xAA, 0xBB};
  data.validity_mask = {0xCC, 0xDD, 0xEE};
  return data;
}

TEST(SideData, HasTheDocumentedBytes) {            // docs/internals/sei.md
  const Bytes expected = {0, 0, 0, 1, 0x67, 0x11,  // parameter sets first
                          0, 0, 0, 1, 0x68, 0x22,  //
                          0, 0, 0, 1, 0x06,        // SEI
                          5, 56,                   // user_data_unregistered, 56 bytes
                          0x5c, 0x1e, 0x37, 0xa0, 0x2f, 0x6b, 0x4d, 0x58, 0x9e, 0x43, 0xc0, 0x97, 0xe5, 0x1d,
                          0x80, 0x6a,                                      // UUID
                          0x6e, 0x87, 0x16, 0x57,                          // CRC-32
                          3,                                               // layout
                          1,                                               // flags: colour, no pose
                          24,                                              // QP
                          0x08, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01,  // sequence
                          0x07, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01,  // previous
                          0x00, 0xca, 0x9a, 0x3b, 0, 0, 3, 0, 0,           // capture time, with an
                                                                           // emulation prevention
                                                                           // byte, 3
                          3, 2, 0, 0, 3, 0,                                // table's size, with two of them
                          0xaa, 0xbb,                                      // table
                          0xcc, 0xdd, 0xee,                                // mask
                          0x80,                                            // end of the SEI
                          0, 0, 0, 1, 0x65, 0x33, 0x44};                   // slice
  EXPECT_EQ(add_side_data(kDepth, kColor, example()), expected);
}

TEST(SideData, ComesBackAsItWas) {
  SideData data = example();
  EXPECT_EQ(extract_side_data(add_side_data(kDepth, kColor, data), kColor).value(), data);
  data.has_color = false;
  EXPECT_EQ(extract_side_data(add_side_data(kDepth, {}, data), {}).value(), data);
  data.world_from_camera =
      Rigid3{Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix(), {1, -2, 0.1}};
  data.previous = 0;
  data.captured_at = Instant(std::chrono::nanoseconds(kNumberBound - 1));
  data.table.clear();
  data.validity_mask.clear();
  EXPECT_EQ(extract_side_data(add_side_data(kDepth, {}, data), {}).value(), data);
  data.residuals = {7};
  EXPECT_EQ(extract_side_data(add_side_data(kDepth, {}, data), {}).value(), data);
  data.residuals.assign(40'000, 2);
  data.validity_mask.assign(100'000, 0);
  EXPECT_EQ(extract_side_data(add_side_data(kDepth, {}, data), {}).value(), data);
}

TEST(SideData, StandsEveryFlippedBitAndEveryCutOnlyAsAnError) {
  SideData data = example();
  data.world_from_camera = Rigid3{};
  data.residuals = {1, 2};
  const Bytes depth = add_side_data(kDepth, kColor, data);
  for (std::size_t bit = 0; bit < 8 * depth.size(); ++bit) {
    Bytes damaged = depth;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(extract_side_data(damaged, kColor)) << "bit " << bit;
  }
  for (std::size_t size = 0; size < depth.size(); ++size) {
    EXPECT_FALSE(extract_side_data(std::span(depth).first(size), kColor)) << size;
  }
  for (std::size_t bit = 0; bit < 8 * kColor.size(); ++bit) {
    Bytes damaged = kColor;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(extract_side_data(depth, damaged)) << "colour bit " << bit;
  }
  for (std::size_t size = 0; size < kColor.size(); ++size) {
    EXPECT_FALSE(extract_side_data(depth, std::span(kColor).first(size))) << size;
  }
}

TEST(SideData, BelievesNoExtremeNumbers) {
  const auto refused = [](const std::function<void(SideData&)>& change) {
    SideData data = example();
    data.world_from_camera = Rigid3{};
    change(data);
    const auto extracted = extract_side_data(add_side_data(kDepth, kColor, data), kColor);
    return !extracted && extracted.error().code == ErrorCode::kCorrupt;
  };
  using Nanoseconds = std::chrono::nanoseconds;
  EXPECT_FALSE(refused([](SideData&) {}));
  for (const Nanoseconds time :
       {Nanoseconds::min(), Nanoseconds(-1), Nanoseconds(kNumberBound), Nanoseconds::max()}) {
    EXPECT_TRUE(refused([time](SideData& data) { data.captured_at = Instant(time); })) << time.count();
  }
  for (const std::uint64_t number : {kNumberBound, std::numeric_limits<std::uint64_t>::max()}) {
    EXPECT_TRUE(refused([number](SideData& data) { data.sequence = number; })) << number;
    EXPECT_TRUE(refused([number](SideData& data) { data.previous = number; })) << number;
  }
  for (const double metres : {1.01e4, -1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE(refused([=](SideData& data) { data.world_from_camera->translation(axis) = metres; }))
          << metres;
    }
    EXPECT_TRUE(refused([=](SideData& data) { data.world_from_camera->rotation(1, 2) = metres; })) << metres;
  }
}

TEST(SideData, HoldsDepthToItsColor) {
  const Bytes other = {0, 0, 0, 1, 0x61, 0x55, 0x77};
  const Bytes depth = add_side_data(kDepth, kColor, example());
  EXPECT_FALSE(extract_side_data(depth, other));
  EXPECT_FALSE(extract_side_data(depth, {}));
  SideData without = example();
  without.has_color = false;
  EXPECT_FALSE(extract_side_data(add_side_data(kDepth, {}, without), kColor));
}

TEST(SideData, StaysWhenACopyAddsWhatH264Allows) {
  const SideData data = example();
  const Bytes depth = add_side_data(kDepth, kColor, data);
  Bytes copied;
  append_nal(copied, Bytes{0x09, 0xF0});  // an access unit delimiter, as MPEG-TS adds
  const auto nals = split_access_unit(depth).value();
  for (const Nal& nal : nals) {
    for (const int byte : {0, 0, 1})
      copied.push_back(static_cast<std::uint8_t>(byte));  // short start codes, as other writers use
    copied.insert(copied.end(), nal.bytes.begin(), nal.bytes.end());
  }
  append_nal(copied, Bytes{0x0C, 0xFF, 0x80});  // filler
  EXPECT_EQ(extract_side_data(copied, kColor).value(), data);
}

}  // namespace
}  // namespace copresence::bitstream
