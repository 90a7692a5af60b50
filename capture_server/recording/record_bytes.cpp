#include "capture_server/recording/record_bytes.h"

#include <algorithm>
#include <bit>

namespace copresence::recording {

std::optional<std::span<const std::uint8_t>> RecordBytes::at(std::uint64_t offset, std::uint32_t count) {
  if (offset > size_ || count > size_ - offset) return std::nullopt;
  const bool inside = offset >= window_at_ && offset + count <= window_at_ + window_.size();
  if (!inside) {
    window_.resize(std::min<std::uint64_t>(std::max<std::uint64_t>(count, kWindow), size_ - offset));
    window_at_ = offset;
    if (!read_(offset, window_)) {
      window_.clear();
      return std::nullopt;
    }
  }
  return std::span<const std::uint8_t>(window_).subspan(offset - window_at_, count);
}

std::span<const std::uint8_t> FieldReader::take(std::size_t bytes) {
  if (!ok_ || bytes > left_.size()) {
    ok_ = false;
    return {};
  }
  const auto taken = left_.first(bytes);
  left_ = left_.subspan(bytes);
  return taken;
}

std::uint64_t FieldReader::number(std::size_t bytes) {
  std::uint64_t value = 0;
  int shift = 0;
  for (const std::uint8_t byte : take(bytes)) {
    value |= std::uint64_t{byte} << shift;
    shift += 8;
  }
  return value;
}

double FieldReader::f64() {
  return std::bit_cast<double>(u64());
}

std::string_view FieldReader::text() {
  const auto bytes = take(u32());
  // OpenNI2 uses each character of a name, as a signed number, as an index into a table. So OpenNI2
  // crashes on characters beyond ASCII.
  if (bytes.empty() || bytes.back() != 0 ||
      std::any_of(bytes.begin(), bytes.end() - 1, [](std::uint8_t c) { return c < 0x20 || c > 0x7e; })) {
    ok_ = false;
    return {};
  }
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1};
}

std::span<const std::uint8_t> FieldReader::blob() {
  return take(u32());
}

RecordHead parse_record_head(std::span<const std::uint8_t> bytes) {
  FieldReader fields(bytes);
  RecordHead head;
  head.magic = fields.u32();
  head.type = static_cast<RecordType>(fields.u32());
  head.node = fields.u32();
  head.fields_bytes = fields.u32();
  head.payload_bytes = fields.u32();
  return head;
}

}  // namespace copresence::recording
