#pragma once

// Writes the file of a recording. Bytes are appended or overwritten. Failures are sentences for the
// user.
// Thread: one thread at a time.

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::file {

/// The treatment of an existing file. Nothing is overwritten without the user's request.
enum class Existing {
  kKeep,     ///< Creating the file fails.
  kReplace,  ///< The file is emptied.
};

class OutputFile {
 public:
  /// Creates the file. If several processes create the same name with kKeep, exactly one of them
  /// succeeds. Devices and named pipes are opened without being emptied.
  /// Fails with kInvalid if the file exists and `existing` is kKeep. Fails with kUnavailable if
  /// writing fails.
  static Result<OutputFile> create(const std::string& path, Existing existing = Existing::kKeep);
  /// Creates `path`, or the first of `name-2.ext`, `name-3.ext` and so on that does not exist yet.
  /// Fails with kInvalid if 10 000 names are taken, and with kUnavailable on a failed write.
  static Result<OutputFile> create_numbered(const std::string& path);
  /// Opens an existing file to change it in place. Fails with kNotFound or kUnavailable.
  static Result<OutputFile> open(const std::string& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Appends bytes. After a failure the file is unchanged.
  /// Fails with kUnavailable if the disk is full or removed, or if the file has its maximum size.
  Result<void> append(std::span<const std::uint8_t> bytes);

  /// Overwrites bytes of the file. Requires offset + bytes.size() <= size(). Fails like append().
  Result<void> write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// Cuts the file off at `size`. Requires size <= size().
  Result<void> truncate(std::uint64_t size);

  /// Closes the file. Call it last. Fails if the system reports a delayed write failure.
  Result<void> close();

  /// Deletes a file that could not be completed. Call discard() instead of close(). Devices and
  /// pipes stay.
  void discard();

 private:
  OutputFile(std::string path, int descriptor, std::uint64_t size)
      : path_(std::move(path)), descriptor_(descriptor), size_(size) {}
  Result<void> write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  tl::unexpected<Error> failure() const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace copresence::file
