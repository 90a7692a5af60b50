#include "common/wire/transport/opening.h"

namespace copresence::wire {
namespace {

// RFC 8446, sections 4 and 5.1.
constexpr std::uint8_t kAlert = 21, kHandshake = 22, kClientHello = 1;
constexpr std::size_t kRecordHead = 5, kHandshakeHead = 4;

}  // namespace

Opening recognise(std::span<const std::uint8_t, kOpeningBytes> bytes) {
  if (bytes[0] != kHandshake || bytes[1] != 3) return {Opening::Kind::kPlain};
  const std::size_t in_record = std::size_t{bytes[3]} << 8 | bytes[4];
  const std::size_t in_hello = std::size_t{bytes[6]} << 16 | std::size_t{bytes[7]} << 8 | bytes[8];
  const bool is_one_record = bytes[5] == kClientHello && in_record == kHandshakeHead + in_hello;
  const std::size_t whole = kRecordHead + in_record;
  if (!is_one_record || whole > kMostOfAClientHello) return {Opening::Kind::kBroken};
  return {Opening::Kind::kTls, whole};
}

bool answers_in_tls(std::uint8_t first_byte) {
  return first_byte == kHandshake || first_byte == kAlert;
}

}  // namespace copresence::wire
