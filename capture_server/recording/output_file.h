#pragma once

// A recording's file while it is written: bytes go to its end or over what is there, and every failure is a
// sentence for the person whose disk it is.
//
// Thread: one thread at a time.

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::recording {

/// What happens to a file that is already there. Nothing is overwritten unless the user asked for it.
enum class Existing {
  kKeep,     ///< creating fails
  kReplace,  ///< the file is emptied
};

class OutputFile {
 public:
  /// Creates the file. With kKeep exactly one of several processes that create the same name succeeds.
  /// What is no regular file (/dev/full, a named pipe that is being read) is opened as it is.
  /// Fails  kInvalid (kKeep: a file of this name exists), kUnavailable (it cannot be written).
  static Result<OutputFile> create(const std::string& path, Existing existing = Existing::kKeep);
  /// Creates `path`, or the first of `name-2.ext`, `name-3.ext` and so on that does not exist yet.
  /// Fails  kInvalid (10 000 names are taken), kUnavailable (it cannot be written).
  static Result<OutputFile> create_numbered(const std::string& path);
  /// Opens a file that is there, to be changed in place. Fails (kNotFound, kUnavailable).
  static Result<OutputFile> open(const std::string& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Writes at the end. A failure leaves the file as it was.
  /// Fails  kUnavailable: the disk is full, the file as large as it may be, the medium gone.
  Result<void> append(std::span<const std::uint8_t> bytes);

  /// Writes over what is there. Requires offset + bytes.size() <= size(). Fails as append().
  Result<void> write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// Cuts off what lies from `size` on. Requires size <= size().
  Result<void> truncate(std::uint64_t size);

  /// Call it last. Fails where the system has kept a failure back until now.
  Result<void> close();

  /// Instead of close(): takes away a file that could not be completed. What is no plain file stays.
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
