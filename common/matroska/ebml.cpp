#include "common/matroska/ebml.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace copresence::matroska {
namespace {

void append_big_endian(Bytes& out, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

int bytes_of(std::uint64_t value) {
  return std::max(1, (static_cast<int>(std::bit_width(value)) + 7) / 8);
}

std::uint64_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

}  // namespace

void append_id(Bytes& out, Id id) {
  append_big_endian(out, static_cast<std::uint32_t>(id), bytes_of(static_cast<std::uint32_t>(id)));
}

void append_size(Bytes& out, std::uint64_t size) {
  // A size of n bytes has 7 n bits. All bits set would mean an unknown size.
  int bytes = 1;
  while (bytes < 8 && size >= (std::uint64_t{1} << (7 * bytes)) - 1) ++bytes;
  append_big_endian(out, size | std::uint64_t{1} << (7 * bytes), bytes);
}

void append_long_size(Bytes& out, std::uint64_t size) {
  assert(size <= kUnknownSize);
  append_big_endian(out, size | std::uint64_t{1} << 56, kLongSizeBytes);
}

void append_number(Bytes& out, Id id, std::uint64_t value) {
  append_id(out, id);
  append_size(out, static_cast<std::uint64_t>(bytes_of(value)));
  append_big_endian(out, value, bytes_of(value));
}

void append_long_number(Bytes& out, Id id, std::uint64_t value) {
  append_id(out, id);
  append_size(out, 8);
  append_big_endian(out, value, 8);
}

void append_real(Bytes& out, Id id, double value) {
  append_long_number(out, id, std::bit_cast<std::uint64_t>(value));
}

void append_text(Bytes& out, Id id, std::string_view value) {
  append_id(out, id);
  append_size(out, value.size());
  out.insert(out.end(), value.begin(), value.end());
}

void append_bytes(Bytes& out, Id id, std::span<const std::uint8_t> value) {
  append_id(out, id);
  append_size(out, value.size());
  out.insert(out.end(), value.begin(), value.end());
}

std::optional<ElementHead> read_element_head(std::span<const std::uint8_t> bytes) {
  if (bytes.empty() || bytes[0] == 0) return std::nullopt;
  // The number of leading zero bits says how many bytes follow the first one.
  const auto id_bytes = static_cast<std::size_t>(std::countl_zero(bytes[0])) + 1;
  if (id_bytes > 4 || bytes.size() <= id_bytes || bytes[id_bytes] == 0) return std::nullopt;
  const auto size_bytes = static_cast<std::size_t>(std::countl_zero(bytes[id_bytes])) + 1;
  if (bytes.size() < id_bytes + size_bytes) return std::nullopt;
  const std::uint64_t most = (std::uint64_t{1} << (7 * size_bytes)) - 1;
  const std::uint64_t size = big_endian(bytes.subspan(id_bytes, size_bytes)) & most;
  return ElementHead{static_cast<Id>(big_endian(bytes.first(id_bytes))), size == most ? kUnknownSize : size,
                     id_bytes + size_bytes};
}

std::uint64_t Element::number() const {
  return contents.size() <= 8 ? big_endian(contents) : 0;
}

std::string Element::text() const {
  return {contents.begin(), std::find(contents.begin(), contents.end(), 0)};
}

std::optional<Element> ElementReader::next() {
  const auto head = read_element_head(left_);
  if (!head || head->bytes > left_.size() - head->head_bytes) {
    left_ = {};
    return std::nullopt;
  }
  const Element element{head->id, left_.subspan(head->head_bytes, head->bytes)};
  left_ = left_.subspan(head->head_bytes + head->bytes);
  return element;
}

}  // namespace copresence::matroska
