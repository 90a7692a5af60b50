#pragma once

// Access to the bytes of a recording for its parsers: in any order, with bounds checks, and with
// little memory.
//
// Thread: one thread at a time.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture_server/recording/oni_format.h"

namespace copresence::recording {

/// Reads `into.size()` bytes from `offset` on; false if the medium fails.
using ReadAt = std::function<bool(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// A window into a file, so that short reads close to each other need one call of the medium.
class RecordBytes {
 public:
  static constexpr std::size_t kWindow = 4096;

  RecordBytes(std::uint64_t size, ReadAt read) : size_(size), read_(std::move(read)) {}

  std::uint64_t size() const { return size_; }

  /// `count` bytes from `offset` on, valid until the next call. Nothing if they are outside the
  /// file or cannot be read.
  std::optional<std::span<const std::uint8_t>> at(std::uint64_t offset, std::uint32_t count);

 private:
  std::uint64_t size_;
  ReadAt read_;
  std::vector<std::uint8_t> window_;
  std::uint64_t window_at_ = 0;
};

/// The fields of one record in order, little-endian. After a read beyond the end, `whole()` stays
/// false.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> fields) : left_(fields) {}

  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  double f64();

  /// A length that includes the final NUL, then the text: printable ASCII, returned without the
  /// NUL.
  std::string_view text();

  /// A length, then bytes.
  std::span<const std::uint8_t> blob();

  /// Whether everything read so far was present.
  bool ok() const { return ok_; }
  /// Whether everything read so far was present and nothing is left.
  bool whole() const { return ok_ && left_.empty(); }

 private:
  std::uint64_t number(std::size_t bytes);
  std::span<const std::uint8_t> take(std::size_t bytes);

  std::span<const std::uint8_t> left_;
  bool ok_ = true;
};

/// The first fields of a record, unchecked.
struct RecordHead {
  std::uint32_t magic = 0;  ///< kRecordMagic if a record begins here
  RecordType type{};
  std::uint32_t node = 0;
  std::uint32_t fields_bytes = 0;   ///< head and fields
  std::uint32_t payload_bytes = 0;  ///< meaningful only for types with a payload

  bool has_payload() const { return type == RecordType::kNewData || type == RecordType::kSeekTable; }
};

/// Requires kOldRecordBytes or more.
RecordHead parse_record_head(std::span<const std::uint8_t> bytes);

}  // namespace copresence::recording
