#pragma once

// The file of a recording while it is written. Bytes are appended or overwritten; every failure is
// a sentence for the user.
//
// Thread: one thread at a time.

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::recording {

/// What to do with an existing file. Nothing is overwritten without the user's request.
enum class Existing {
  kKeep,     ///< creating fails
  kReplace,  ///< the file is emptied
};

class OutputFile {
 public:
  /// Creates the file. With kKeep, exactly one of several processes that create the same name
  /// succeeds. Other things than regular files (/dev/full, a named pipe) are opened as they are.
  /// Fails  kInvalid (with kKeep, a file of this name exists), kUnavailable (it cannot be written).
  static Result<OutputFile> create(const std::string& path, Existing existing = Existing::kKeep);
  /// Creates `path`, or the first of `name-2.ext`, `name-3.ext` and so on that does not exist yet.
  /// Fails  kInvalid (10 000 names are taken), kUnavailable (it cannot be written).
  static Result<OutputFile> create_numbered(const std::string& path);
  /// Opens an existing file to change it in place. Fails (kNotFound, kUnavailable).
  static Result<OutputFile> open(const std::string& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Writes at the end. After a failure the file is unchanged.
  /// Fails  kUnavailable: the disk is full, the file has its maximum size, or the medium is gone.
  Result<void> append(std::span<const std::uint8_t> bytes);

  /// Overwrites bytes of the file. Requires offset + bytes.size() <= size(). Fails as append().
  Result<void> write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// Cuts the file off at `size`. Requires size <= size().
  Result<void> truncate(std::uint64_t size);

  /// Call it last. Fails if the system reports a delayed failure.
  Result<void> close();

  /// Instead of close(): deletes a file that could not be completed. Other things than regular
  /// files stay.
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

}  // namespace copresence::recording
