#include "capture_server/recording/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace copresence::recording {

Result<OutputFile> OutputFile::create(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written: {}; give a path in a folder "
                                                     "that you may write to",
                                                     path, std::strerror(errno)));
  }
  return OutputFile(path, descriptor, 0);
}

Result<OutputFile> OutputFile::open(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    return fail(errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
                fmt::format("{}: cannot be changed: {}; check the path and whether you may write there", path,
                            std::strerror(errno)));
  }
  struct stat status {};
  ::fstat(descriptor, &status);
  return OutputFile(path, descriptor, static_cast<std::uint64_t>(status.st_size));
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(std::exchange(other.size_, 0)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tl::unexpected<Error> OutputFile::failure() const {
  const char* reason = errno == ENOSPC || errno == EDQUOT ? "the disk is full; make room or use another one"
                       : errno == EFBIG
                           ? "the file is as large as its file system or a limit (ulimit -f) allows"
                           : std::strerror(errno);
  return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written: {}", path_, reason));
}

Result<void> OutputFile::append(std::span<const std::uint8_t> bytes) {
  if (auto written = write(size_, bytes); !written) {
    // Best effort: what stays behind a recording's end disturbs nobody.
    [[maybe_unused]] const int cut = ::ftruncate(descriptor_, static_cast<off_t>(size_));
    return written;
  }
  size_ += bytes.size();
  return {};
}

Result<void> OutputFile::write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  assert(offset + bytes.size() <= size_);
  return write(offset, bytes);
}

Result<void> OutputFile::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  assert(descriptor_ >= 0);
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put == 0) errno = EIO;
    if (put <= 0) return failure();
    bytes = bytes.subspan(static_cast<std::size_t>(put));
    offset += static_cast<std::uint64_t>(put);
  }
  return {};
}

Result<void> OutputFile::truncate(std::uint64_t size) {
  assert(size <= size_);
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return failure();
  size_ = size;
  return {};
}

void OutputFile::discard() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path_, ignored)) std::filesystem::remove(path_, ignored);
}

Result<void> OutputFile::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) return failure();
  return {};
}

}  // namespace copresence::recording
