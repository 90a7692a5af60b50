#include "tools/depth_bench/rvl.h"

#include <cstring>

namespace copresence::depth_bench {
namespace {

class NibbleWriter {
 public:
  void number(std::uint32_t value) {
    do {
      const std::uint32_t more = value > 7 ? 8u : 0u;
      word_ = word_ << 4 | (value & 7) | more;
      value >>= 3;
      if (++nibbles_ == 8) flush();
    } while (value);
  }
  std::vector<std::uint8_t> finish() {
    if (nibbles_) {
      word_ <<= 4 * (8 - nibbles_);
      flush();
    }
    return std::move(bytes_);
  }

 private:
  void flush() {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + 4);
    std::memcpy(bytes_.data() + at, &word_, 4);
    word_ = 0;
    nibbles_ = 0;
  }
  std::vector<std::uint8_t> bytes_;
  std::uint32_t word_ = 0;
  int nibbles_ = 0;
};

class NibbleReader {
 public:
  explicit NibbleReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint32_t number() {
    std::uint32_t value = 0, nibble = 8;
    for (int shift = 0; (nibble & 8) && shift < 32; shift += 3) {
      if (nibbles_ == 0) refill();
      nibble = word_ >> 28;
      word_ <<= 4;
      --nibbles_;
      value |= (nibble & 7) << shift;
    }
    return value;
  }

 private:
  void refill() {
    word_ = 0;
    if (at_ + 4 <= bytes_.size()) std::memcpy(&word_, bytes_.data() + at_, 4);
    at_ += 4;
    nibbles_ = 8;
  }
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::uint32_t word_ = 0;
  int nibbles_ = 0;
};

}  // namespace

std::vector<std::uint8_t> encode_rvl(std::span<const std::uint16_t> depth) {
  NibbleWriter out;
  std::int32_t before = 0;
  for (std::size_t i = 0; i < depth.size();) {
    std::size_t zeros = i;
    while (zeros < depth.size() && depth[zeros] == 0) ++zeros;
    out.number(static_cast<std::uint32_t>(zeros - i));
    i = zeros;
    std::size_t end = i;
    while (end < depth.size() && depth[end] != 0) ++end;
    out.number(static_cast<std::uint32_t>(end - i));
    for (; i < end; ++i) {
      const std::int32_t change = depth[i] - before;
      out.number(static_cast<std::uint32_t>(change << 1 ^ change >> 31));
      before = depth[i];
    }
  }
  return out.finish();
}

void decode_rvl(std::span<const std::uint8_t> bytes, std::span<std::uint16_t> depth) {
  NibbleReader in(bytes);
  std::int32_t before = 0;
  for (std::size_t i = 0; i < depth.size();) {
    for (std::uint32_t zeros = in.number(); zeros && i < depth.size(); --zeros) depth[i++] = 0;
    for (std::uint32_t values = in.number(); values && i < depth.size(); --values) {
      const std::uint32_t code = in.number();
      before += static_cast<std::int32_t>(code >> 1) ^ -static_cast<std::int32_t>(code & 1);
      depth[i++] = static_cast<std::uint16_t>(before);
    }
  }
}

}  // namespace copresence::depth_bench
