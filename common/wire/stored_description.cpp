#include "common/wire/stored_description.h"

#include <fmt/format.h>

#include <utility>

#include "common/wire/byte_order.h"
#include "common/wire/message_codec.h"

namespace copresence::wire {

std::vector<std::uint8_t> store_description(const StreamDescription& description) {
  Bytes bytes;
  ByteWriter(bytes).number(kProtocolVersion);
  const Bytes welcome = encode(Welcome{0, {}, description});
  bytes.insert(bytes.end(), welcome.begin() + kHeaderBytes, welcome.end());
  return bytes;
}

Result<StreamDescription> load_description(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kVersionBytes = sizeof(kProtocolVersion);
  if (bytes.size() < kVersionBytes) return fail(ErrorCode::kCorrupt, "a stream description that is cut off");
  const auto version = ByteReader(bytes).number<std::uint32_t>();
  if (version < kOldestStoredVersion || version > kProtocolVersion) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("its stream description has version {}, and this release reads {} to {}: use the "
                            "release that wrote it",
                            version, kOldestStoredVersion, kProtocolVersion));
  }
  auto welcome = decode_welcome(bytes.subspan(kVersionBytes));
  if (!welcome) return fail(welcome.error());
  return std::move(welcome->description);
}

}  // namespace copresence::wire
