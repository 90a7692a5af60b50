#pragma once

// Reads a file of any size at any offset.
// Thread: concurrent reads are safe.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::file {

class InputFile {
 public:
  /// Fails with kNotFound if the file does not exist, cannot be read, or is not a regular file. The
  /// message asks for `expected`, for example "an .oni recording".
  static Result<InputFile> open(const std::string& path, std::string_view expected);

  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  std::uint64_t size() const { return size_; }

  /// Fills `into` with the bytes from `offset` on. Returns false beyond the file's end or if the
  /// disk fails.
  bool read(std::uint64_t offset, std::span<std::uint8_t> into) const;

 private:
  InputFile(int descriptor, std::uint64_t size) : descriptor_(descriptor), size_(size) {}

  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace copresence::file
