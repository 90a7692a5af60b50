#include "common/bitstream/length_prefixed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::bitstream {
namespace {

using ::testing::ElementsAre;

const std::vector<std::uint8_t> kAccessUnit = {0, 0,    0, 1, 0x67, 110, 0,    51, 7, 0, 0,
                                               1, 0x68, 9, 0, 0,    1,   0x65, 1,  2, 3};

TEST(LengthPrefixed, NalUnitsSurviveTheWayThereAndBack) {
  const auto nals = split_access_unit(kAccessUnit);
  ASSERT_TRUE(nals);
  const auto prefixed = to_length_prefixed(*nals);
  EXPECT_THAT(prefixed,
              ElementsAre(0, 0, 0, 5, 0x67, 110, 0, 51, 7, 0, 0, 0, 2, 0x68, 9, 0, 0, 0, 4, 0x65, 1, 2, 3));
  const auto back = from_length_prefixed(prefixed);
  ASSERT_TRUE(back);
  const auto again = split_access_unit(*back);
  ASSERT_TRUE(again);
  ASSERT_EQ(again->size(), nals->size());
  for (std::size_t i = 0; i < nals->size(); ++i)
    EXPECT_THAT((*again)[i].bytes, ::testing::ElementsAreArray((*nals)[i].bytes));
}

TEST(LengthPrefixed, LengthsThatDoNotAddUpAreCorrupt) {
  for (const std::vector<std::uint8_t>& bytes : {std::vector<std::uint8_t>{0, 0, 0, 2, 1},
                                                 {0, 0, 0, 0, 1},
                                                 {0, 0, 1},
                                                 {255, 255, 255, 255, 1},
                                                 {0, 0, 0, 1}}) {
    const auto unit = from_length_prefixed(bytes);
    ASSERT_FALSE(unit);
    EXPECT_EQ(unit.error().code, ErrorCode::kCorrupt);
  }
}

// ISO/IEC 14496-15, 5.3.3.1.2: version, profile, compatibility, level, bytes of a length less one,
// parameter sets, and for this profile the format of chroma and the bits beyond 8.
TEST(LengthPrefixed, TheConfigurationRecordStatesTheFormat) {
  const auto nals = split_access_unit(kAccessUnit);
  ASSERT_TRUE(nals);
  const auto record = avc_configuration(*nals, PixelFormat::kGray10);
  ASSERT_TRUE(record);
  EXPECT_THAT(*record, ElementsAre(1, 110, 0, 51, 0xFF, 0xE1, 0, 5, 0x67, 110, 0, 51, 7, 1, 0, 2, 0x68, 9,
                                   0xFC, 0xFA, 0xFA, 0));
}

TEST(LengthPrefixed, WithoutParameterSetsThereIsNoConfigurationRecord) {
  const auto nals = split_access_unit(std::span(kAccessUnit).subspan(14));
  ASSERT_TRUE(nals);
  EXPECT_FALSE(avc_configuration(*nals, PixelFormat::kGray10));
}

}  // namespace
}  // namespace copresence::bitstream
