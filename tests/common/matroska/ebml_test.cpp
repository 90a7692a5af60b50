#include "common/matroska/ebml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::matroska {
namespace {

using ::testing::ElementsAre;

// The numbers of RFC 8794, section 4.4: 127 of 7 bits means an unknown size, so 127 takes two bytes.
TEST(Ebml, SizesTakeAsFewBytesAsPossible) {
  Bytes bytes;
  append_size(bytes, 2);
  append_size(bytes, 126);
  append_size(bytes, 127);
  append_size(bytes, 16'382);
  append_size(bytes, 16'383);
  EXPECT_THAT(bytes, ElementsAre(0x82, 0xFE, 0x40, 0x7F, 0x7F, 0xFE, 0x20, 0x3F, 0xFF));
}

TEST(Ebml, ElementsAreReadAsTheyWereWritten) {
  Bytes bytes;
  append_number(bytes, Id::kTimestamp, 0x1234);
  append_text(bytes, Id::kName, "left depth");
  append_bytes(bytes, Id::kFileData, Bytes(300, 7));
  ElementReader reader(bytes);
  auto element = reader.next();
  ASSERT_TRUE(element);
  EXPECT_EQ(element->id, Id::kTimestamp);
  EXPECT_EQ(element->number(), 0x1234u);
  element = reader.next();
  ASSERT_TRUE(element);
  EXPECT_EQ(element->text(), "left depth");
  element = reader.next();
  ASSERT_TRUE(element);
  EXPECT_EQ(element->contents.size(), 300u);
  EXPECT_FALSE(reader.next());
}

TEST(Ebml, AnElementThatIsLongerThanItsParentEndsTheList) {
  Bytes bytes;
  append_text(bytes, Id::kName, "left depth");
  bytes.pop_back();
  EXPECT_FALSE(ElementReader(bytes).next());
  EXPECT_FALSE(ElementReader(Bytes{0x00, 0x80}).next()) << "no identifier begins with a zero byte";
}

TEST(Ebml, AnUnknownSizeIsRecognisedAtEveryLength) {
  for (const Bytes& size : {Bytes{0xFF}, Bytes{0x7F, 0xFF}, Bytes{1, 255, 255, 255, 255, 255, 255, 255}}) {
    Bytes bytes;
    append_id(bytes, Id::kCluster);
    bytes.insert(bytes.end(), size.begin(), size.end());
    const auto head = read_element_head(bytes);
    ASSERT_TRUE(head);
    EXPECT_EQ(head->bytes, kUnknownSize);
    EXPECT_EQ(head->head_bytes, bytes.size());
  }
}

}  // namespace
}  // namespace copresence::matroska
