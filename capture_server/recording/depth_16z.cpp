#include "capture_server/recording/depth_16z.h"

#include <array>
#include <bit>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <numeric>

namespace copresence::recording {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr int kLargestNibble = 6, kLargestByte = 63;
constexpr int kZeros = 0x66, kLongestRun = 15;

void append_u16(std::vector<std::uint8_t>& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

class Differences {
 public:
  explicit Differences(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  void nibble(int value) {
    if (pending_ < 0) {
      pending_ = value;
      return;
    }
    const int byte = pending_ << 4 | value;
    pending_ = -1;
    if (byte == kZeros) {
      if (++run_ == kLongestRun) end_run();
    } else {
      end_run();
      push(byte);
    }
  }

  void escape() {
    end_run();
    push(pending_ < 0 ? 0xFF : pending_ << 4 | 0xF);
    pending_ = -1;
  }

  void push(int byte) { bytes_.push_back(static_cast<std::uint8_t>(byte)); }

  void finish() {
    end_run();
    if (pending_ >= 0) push(pending_ << 4 | 0xD);
  }

 private:
  void end_run() {
    if (run_ > 0) push(0xE0 + run_);
    run_ = 0;
  }

  std::vector<std::uint8_t>& bytes_;
  int pending_ = -1;  // Nibble that waits for the second nibble of its byte.
  int run_ = 0;       // Number of bytes 0x66 that are not written yet.
};

tl::unexpected<Error> corrupt(const char* what) {
  return fail(ErrorCode::kCorrupt, std::string("a depth frame is damaged: ") + what);
}

}  // namespace

Result<void> append_depth_16z(const DepthImage& depth, std::vector<std::uint8_t>& bytes) {
  assert(!depth.empty());
  std::vector<std::uint16_t> index_of(65536, 0);
  for (const std::uint16_t value : depth.pixels()) index_of[value] = 1;
  std::size_t count = 0;
  for (const std::uint16_t used : index_of) count += used;
  if (count > 32767) {
    return fail(ErrorCode::kUnsupported,
                "a depth frame of more than 32767 distinct values cannot be coded as 16zT");
  }
  append_u16(bytes, static_cast<unsigned>(count));
  std::uint16_t next = 0;
  for (unsigned value = 0; value < index_of.size(); ++value) {
    if (!index_of[value]) continue;
    index_of[value] = next++;
    append_u16(bytes, value);
  }

  int before = index_of[depth.data()[0]];
  append_u16(bytes, static_cast<unsigned>(before));
  Differences differences(bytes);
  for (const std::uint16_t value : depth.pixels().subspan(1)) {
    const int index = index_of[value];
    const int d = before - index;
    if (std::abs(d) <= kLargestNibble) {
      differences.nibble(d + kLargestNibble);
    } else {
      differences.escape();
      if (std::abs(d) <= kLargestByte) {
        differences.push(d + 192);
      } else {
        differences.push(index >> 8);
        differences.push(index & 0xFF);
      }
    }
    before = index;
  }
  differences.finish();
  return {};
}

Result<void> expand_depth_16z(std::span<const std::uint8_t> bytes, DepthTable table, DepthImage& depth) {
  const auto u16_at = [&](std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
  };
  std::array<std::uint16_t, 65536> values;  // Table that gives the depth of each index.
  std::size_t entries = values.size(), at = 0;
  if (table == DepthTable::kEmbedded) {
    if (bytes.size() < 2) return corrupt("no table");
    entries = u16_at(0);
    at = 2 + 2 * entries;
    if (bytes.size() < at) return corrupt("its table is cut off");
    std::memcpy(values.data(), bytes.data() + 2, 2 * entries);
  } else {
    std::iota(values.begin(), values.end(), std::uint16_t{0});
  }
  if (bytes.size() < at + 2) return corrupt("it has no first pixel");
  if (depth.empty()) return corrupt("the expected picture has no pixels");

  int index = u16_at(at);
  at += 2;
  if (static_cast<std::size_t>(index) >= entries) return corrupt("its first pixel is not in the table");
  auto out = depth.pixels().begin();
  const auto end = depth.pixels().end();
  *out++ = values[static_cast<std::size_t>(index)];
  const auto put = [&](int new_index) {
    if (out == end || new_index < 0 || static_cast<std::size_t>(new_index) >= entries) return false;
    index = new_index;
    *out++ = values[static_cast<std::size_t>(index)];
    return true;
  };

  while (at < bytes.size()) {
    const int high = bytes[at] >> 4, low = bytes[at] & 0xF;
    ++at;
    if (high == 0xE) {
      for (int i = 0; i < 2 * low; ++i) {
        if (!put(index)) return corrupt("a run leaves the picture");
      }
      continue;
    }
    bool escaped = high == 0xF;
    if (!escaped) {
      if (high > 0xC || !put(index + kLargestNibble - high))
        return corrupt("a difference leads out of the table or the picture");
      if (low == 0xD) continue;
      escaped = low == 0xF;
      if (!escaped && (low > 0xC || !put(index + kLargestNibble - low))) {
        return corrupt("a difference leads out of the table or the picture");
      }
    }
    if (!escaped) continue;
    if (at >= bytes.size()) return corrupt("it ends within an escape");
    const int first = bytes[at++];
    if (first >= 0x80) {
      if (!put(index + 192 - first)) return corrupt("a difference leads out of the table or the picture");
    } else {
      if (at >= bytes.size()) return corrupt("it ends within an escape");
      if (!put(first << 8 | bytes[at++])) return corrupt("an index lies outside the table or the picture");
    }
  }
  if (out != end) return corrupt("pixels are missing");
  return {};
}

}  // namespace copresence::recording
