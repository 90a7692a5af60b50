#include "common/bitstream/access_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::bitstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(AccessUnit, SplitsAtStartCodesOfThreeAndFourBytes) {
  const Bytes bytes = {0, 0, 0, 1, 0x67, 1, 2, 0, 0, 1, 0x68, 9, 0, 0, 0, 0, 1, 0x65, 5, 0, 7};
  const auto nals = split_access_unit(bytes);
  ASSERT_TRUE(nals);
  ASSERT_EQ(nals->size(), 3u);
  EXPECT_THAT((*nals)[0].bytes, testing::ElementsAre(0x67, 1, 2));
  EXPECT_THAT((*nals)[1].bytes, testing::ElementsAre(0x68, 9));
  EXPECT_THAT((*nals)[2].bytes, testing::ElementsAre(0x65, 5, 0, 7));
  EXPECT_EQ((*nals)[2].type(), NalType::kIdrSlice);
}

TEST(AccessUnit, RefusesWhatIsNone) {
  for (const Bytes& bytes :
       {Bytes{}, Bytes{0}, Bytes{0, 0}, Bytes{0, 0, 1}, Bytes{0, 0, 0, 1}, Bytes{1, 2, 3, 4, 5},
        Bytes{7, 0, 0, 1, 0x65, 1}, Bytes{0, 0, 1, 0xE5, 1}, Bytes{0, 0, 1, 0, 0, 1, 0x65}}) {
    const auto nals = split_access_unit(bytes);
    ASSERT_FALSE(nals);
    EXPECT_EQ(nals.error().code, ErrorCode::kCorrupt);
  }
}

TEST(AccessUnit, CallsSlicesAndParameterSetsEssential) {
  for (int type = 0; type < 32; ++type) {
    const Bytes bytes = {static_cast<std::uint8_t>(0x60 | type)};
    EXPECT_EQ(Nal{bytes}.is_essential(), type == 1 || type == 5 || type == 7 || type == 8) << type;
  }
}

TEST(AccessUnit, KeepsStartCodesOutOfPayloads) {
  const Bytes payload = {0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0};
  const Bytes nal = to_nal_bytes(payload);
  EXPECT_THAT(nal, testing::ElementsAre(0, 0, 3, 0, 0, 3, 0, 1, 0, 0, 3, 2, 0, 0, 3, 3, 0, 0, 4, 0, 0));
  EXPECT_EQ(from_nal_bytes(nal), payload);
}

TEST(AccessUnit, EmulationPreventionIsUndoneForEveryShortPayload) {
  for (int code = 0; code < 5 * 5 * 5 * 5 * 5; ++code) {
    Bytes payload;
    for (int rest = code, i = 0; i < 5; ++i, rest /= 5)
      payload.push_back(static_cast<std::uint8_t>(rest % 5));
    const Bytes nal = to_nal_bytes(payload);
    ASSERT_EQ(from_nal_bytes(nal), payload);
    for (std::size_t i = 0; i + 2 < nal.size(); ++i) {
      ASSERT_FALSE(nal[i] == 0 && nal[i + 1] == 0 && nal[i + 2] < 3) << code;
    }
  }
}

}  // namespace
}  // namespace copresence::bitstream
