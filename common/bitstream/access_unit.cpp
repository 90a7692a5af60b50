#include "common/bitstream/access_unit.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace copresence::bitstream {
namespace {

constexpr std::array<std::uint8_t, 4> kStartCode = {0, 0, 0, 1};

/// Returns the position of the first 00 00 01 at or after `from`, or the size if there is none.
std::size_t find_start_code(std::span<const std::uint8_t> bytes, std::size_t from) {
  for (std::size_t at = from; at + 3 <= bytes.size();) {
    // Search for the 1, since it is rarer than the zeros.
    const void* one = std::memchr(bytes.data() + at + 2, 1, bytes.size() - at - 2);
    if (!one) break;
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(one) - bytes.data()) - 2;
    if (bytes[at] == 0 && bytes[at + 1] == 0) return at;
    ++at;
  }
  return bytes.size();
}

/// Returns the position of the first two zeros that another byte follows, at or after `from`. If
/// there are none, returns the size of `bytes`.
std::size_t find_zeros(std::span<const std::uint8_t> bytes, std::size_t from) {
  for (std::size_t at = from; at + 3 <= bytes.size(); ++at) {
    const void* zero = std::memchr(bytes.data() + at, 0, bytes.size() - 2 - at);
    if (!zero) break;
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(zero) - bytes.data());
    if (bytes[at + 1] == 0) return at;
  }
  return bytes.size();
}

}  // namespace

bool Nal::is_essential() const {
  return type() == NalType::kSlice || type() == NalType::kIdrSlice ||
         type() == NalType::kSequenceParameters || type() == NalType::kPictureParameters;
}

Result<std::vector<Nal>> split_access_unit(std::span<const std::uint8_t> access_unit) {
  std::vector<Nal> nals;
  std::size_t at = find_start_code(access_unit, 0);
  const auto before = access_unit.first(at);
  if (at == access_unit.size() ||
      std::any_of(before.begin(), before.end(), [](auto byte) { return byte != 0; })) {
    return fail(ErrorCode::kCorrupt, "an access unit does not begin with a start code");
  }
  while (at < access_unit.size()) {
    const std::size_t begin = at + 3;
    const std::size_t next = find_start_code(access_unit, begin);
    std::size_t end = next;
    while (end > begin && access_unit[end - 1] == 0) --end;
    if (end == begin || (access_unit[begin] & 0x80) != 0) {
      return fail(ErrorCode::kCorrupt, "an access unit holds an empty or forbidden NAL unit");
    }
    nals.push_back({access_unit.subspan(begin, end - begin)});
    at = next;
  }
  return nals;
}

void append_nal(std::vector<std::uint8_t>& access_unit, std::span<const std::uint8_t> nal) {
  access_unit.insert(access_unit.end(), kStartCode.begin(), kStartCode.end());
  access_unit.insert(access_unit.end(), nal.begin(), nal.end());
}

std::vector<std::uint8_t> to_nal_bytes(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> nal;
  nal.reserve(payload.size() + payload.size() / 64 + 8);
  std::size_t copied = 0;
  for (std::size_t at = find_zeros(payload, 0); at < payload.size(); at = find_zeros(payload, at)) {
    at += 2;
    if (payload[at] > 3) continue;
    nal.insert(nal.end(), payload.begin() + copied, payload.begin() + at);
    nal.push_back(3);
    copied = at;
  }
  nal.insert(nal.end(), payload.begin() + copied, payload.end());
  return nal;
}

std::vector<std::uint8_t> from_nal_bytes(std::span<const std::uint8_t> nal) {
  std::vector<std::uint8_t> payload;
  payload.reserve(nal.size());
  std::size_t copied = 0;
  for (std::size_t at = find_zeros(nal, 0); at < nal.size(); at = find_zeros(nal, at)) {
    at += 2;
    if (nal[at] != 3) continue;
    payload.insert(payload.end(), nal.begin() + copied, nal.begin() + at);
    copied = ++at;
  }
  payload.insert(payload.end(), nal.begin() + copied, nal.end());
  return payload;
}

}  // namespace copresence::bitstream
