#pragma once

// Gives parsers access to a recording's bytes in any order, with bounds checks and little memory.
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
#include "common/file/input_file.h"

namespace copresence::recording {

/// Reads `into.size()` bytes from `offset` on. Returns false if the disk fails.
using ReadAt = std::function<bool(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// A buffered window into a file. Short reads close to each other need only one call of ReadAt.
class RecordBytes {
 public:
  static constexpr std::size_t kWindow = 4096;

  RecordBytes(std::uint64_t size, ReadAt read) : size_(size), read_(std::move(read)) {}
  /// Reads `file`, which must outlive this object.
  explicit RecordBytes(const file::InputFile& file)
      : RecordBytes(file.size(), [&file](std::uint64_t offset, std::span<std::uint8_t> into) {
          return file.read(offset, into);
        }) {}

  std::uint64_t size() const { return size_; }

  /// Returns `count` bytes from `offset` on, valid until the next call. Returns nothing if these
  /// bytes are outside the file or cannot be read.
  std::optional<std::span<const std::uint8_t>> at(std::uint64_t offset, std::uint32_t count);

 private:
  std::uint64_t size_;
  ReadAt read_;
  std::vector<std::uint8_t> window_;
  std::uint64_t window_at_ = 0;
};

/// Reads the little-endian fields of one record in order. A read beyond the end sets ok() to false.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> fields) : left_(fields) {}

  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  double f64();

  /// Reads a length that includes the final NUL, then printable ASCII text. Returns the text only.
  std::string_view text();

  /// Reads a length and then that many bytes.
  std::span<const std::uint8_t> blob();

  /// True if the record contained every field read so far.
  bool ok() const { return ok_; }
  /// True if the record contained every field read so far and nothing else.
  bool whole() const { return ok_ && left_.empty(); }

 private:
  std::uint64_t number(std::size_t bytes);
  std::span<const std::uint8_t> take(std::size_t bytes);

  std::span<const std::uint8_t> left_;
  bool ok_ = true;
};

/// The first fields of a record. Their values are unchecked.
struct RecordHead {
  std::uint32_t magic = 0;  ///< The value is kRecordMagic if a record begins here.
  RecordType type{};
  std::uint32_t node = 0;
  std::uint32_t fields_bytes = 0;   ///< Size of head and fields.
  std::uint32_t payload_bytes = 0;  ///< The size is meaningful only for types with a payload.

  bool has_payload() const { return type == RecordType::kNewData || type == RecordType::kSeekTable; }
};

/// Requires at least kOldRecordBytes bytes.
RecordHead parse_record_head(std::span<const std::uint8_t> bytes);

}  // namespace copresence::recording
