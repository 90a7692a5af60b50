#include "common/wire/stored_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

TEST(StoredDescription, IsLoadedAsItWasStored) {
  const auto loaded = load_description(store_description(sample_description()));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(*loaded, sample_description());
}

TEST(StoredDescription, OfAnotherReleaseIsUnsupported) {
  Bytes bytes = store_description(sample_description());
  bytes[0] = 200;
  const auto loaded = load_description(bytes);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(loaded.error().what, ::testing::HasSubstr("version 200"));
}

TEST(StoredDescription, ThatIsCutOffIsCorrupt) {
  const Bytes bytes = store_description(sample_description());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto loaded = load_description(std::span(bytes).first(size));
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().code, ErrorCode::kCorrupt);
  }
}

}  // namespace
}  // namespace copresence::wire
