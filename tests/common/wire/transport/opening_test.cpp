#include "common/wire/transport/opening.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/wire/message_codec.h"

namespace copresence::wire {
namespace {

using Bytes9 = std::array<std::uint8_t, kOpeningBytes>;

Opening::Kind kind_of(const Bytes9& bytes) {
  return recognise(bytes).kind;
}

TEST(Opening, ATlsClientHelloIsRecognisedWithItsSize) {
  const Opening opening = recognise(Bytes9{22, 3, 1, 0, 200, 1, 0, 0, 196});
  EXPECT_EQ(opening.kind, Opening::Kind::kTls);
  EXPECT_EQ(opening.record_bytes, 205u);
}

TEST(Opening, AHelloOfThisProjectAndOtherProtocolsArePlain) {
  const Bytes hello = encode(Hello{});
  Bytes9 first{};
  std::copy_n(hello.begin(), first.size(), first.begin());
  EXPECT_EQ(kind_of(first), Opening::Kind::kPlain);
  EXPECT_EQ(kind_of({'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T'}), Opening::Kind::kPlain);
  EXPECT_EQ(kind_of({'S', 'S', 'H', '-', '2', '.', '0', '-', 'x'}), Opening::Kind::kPlain);
  EXPECT_EQ(kind_of({}), Opening::Kind::kPlain);
}

TEST(Opening, AClientHelloThatClaimsMoreThanOneSmallRecordIsBroken) {
  EXPECT_EQ(kind_of({22, 3, 1, 0x40, 0, 1, 0, 0x3f, 0xfc}), Opening::Kind::kBroken) << "16 KiB";
  EXPECT_EQ(kind_of({22, 3, 1, 0, 200, 1, 2, 0, 0}), Opening::Kind::kBroken) << "128 KiB in many records";
  EXPECT_EQ(kind_of({22, 3, 1, 0, 200, 1, 0, 0, 20}), Opening::Kind::kBroken) << "two messages in a record";
  EXPECT_EQ(kind_of({22, 3, 1, 0, 0, 1, 0, 0, 0}), Opening::Kind::kBroken) << "an empty record";
  EXPECT_EQ(kind_of({22, 3, 1, 0, 200, 2, 0, 0, 196}), Opening::Kind::kBroken) << "a ServerHello";
}

TEST(Opening, AServerAnswersInTlsWithAHandshakeOrAnAlert) {
  EXPECT_TRUE(answers_in_tls(22));
  EXPECT_TRUE(answers_in_tls(21));
  EXPECT_FALSE(answers_in_tls(encode(Reject{RejectReason::kKeyUnexpected, "no key"}).front()));
  EXPECT_FALSE(answers_in_tls('S'));
}

}  // namespace
}  // namespace copresence::wire
