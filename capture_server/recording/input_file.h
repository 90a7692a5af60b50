#pragma once

// Reads a file of any size at any offset.
// Thread: concurrent reads are safe.

#include <cstdint>
#include <span>
#include <string>

#include "capture_server/recording/record_bytes.h"
#include "common/result.h"

namespace copresence::recording {

class InputFile {
 public:
  /// Fails with kNotFound if the file does not exist, cannot be read, or is not a regular file.
  static Result<InputFile> open(const std::string& path);

  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  std::uint64_t size() const { return size_; }

  /// Fills `into` with the bytes from `offset` on. Returns false beyond the file's end or if the
  /// disk fails.
  bool read(std::uint64_t offset, std::span<std::uint8_t> into) const;

  /// Returns access to this file's bytes for a parser. The InputFile must outlive the result.
  RecordBytes bytes() const;

 private:
  InputFile(int descriptor, std::uint64_t size) : descriptor_(descriptor), size_(size) {}

  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace copresence::recording
