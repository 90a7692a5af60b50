#pragma once

// The bytes of a recording as its check reads them: in whatever order, bounds checked, few of them in memory.
//
// Thread: one thread at a time.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace copresence::recording {

/// Reads `into.size()` bytes from `offset` on; false where the medium fails.
using ReadAt = std::function<bool(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// A window into a file: short reads near each other cost one call of the medium.
class RecordBytes {
 public:
  static constexpr std::size_t kWindow = 4096;

  RecordBytes(std::uint64_t size, ReadAt read) : size_(size), read_(std::move(read)) {}

  std::uint64_t size() const { return size_; }

  /// `count` bytes from `offset` on, valid until the next call; nothing where they lie outside or cannot be
  /// read.
  std::optional<std::span<const std::uint8_t>> at(std::uint64_t offset, std::uint32_t count);

 private:
  std::uint64_t size_;
  ReadAt read_;
  std::vector<std::uint8_t> window_;
  std::uint64_t window_at_ = 0;
};

/// The fields of one record, front to back, little-endian. Reading past the end makes `whole()` false for
/// good.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> fields) : left_(fields) {}

  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  double f64();

  /// A length with its terminating 0 counted, then the text: printable ASCII without it.
  std::string_view text();

  /// A length, then bytes.
  std::span<const std::uint8_t> blob();

  /// Whether everything read so far was there.
  bool ok() const { return ok_; }
  /// Whether everything read so far was there and nothing is left.
  bool whole() const { return ok_ && left_.empty(); }

 private:
  std::uint64_t number(std::size_t bytes);
  std::span<const std::uint8_t> take(std::size_t bytes);

  std::span<const std::uint8_t> left_;
  bool ok_ = true;
};

}  // namespace copresence::recording
