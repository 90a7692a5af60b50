#include "common/file/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace copresence::file {

namespace {

constexpr int kMostNames = 10'000;

tl::unexpected<Error> not_created(const std::string& path) {
  return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written: {}; give a path in a folder that "
                                                   "you may write to",
                                                   path, std::strerror(errno)));
}

bool is_regular(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

std::string numbered(const std::filesystem::path& path, int number) {
  const std::string name = fmt::format("{}-{}{}", path.stem().string(), number, path.extension().string());
  return (path.parent_path() / name).string();
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::string& path, Existing existing) {
  constexpr int kWrite = O_WRONLY | O_CLOEXEC;
  const int how = existing == Existing::kReplace ? O_CREAT | O_TRUNC : O_CREAT | O_EXCL;
  int descriptor = ::open(path.c_str(), kWrite | how, 0666);
  if (descriptor < 0 && errno == EEXIST) {
    descriptor = ::open(path.c_str(), kWrite | O_NONBLOCK);
    // A dangling symbolic link counts as an existing file.
    if (descriptor < 0 ? errno == ENOENT || errno == EACCES : is_regular(descriptor)) {
      if (descriptor >= 0) ::close(descriptor);
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: exists already and is kept; give another name or --overwrite", path));
    }
  }
  if (descriptor < 0) return not_created(path);
  return OutputFile(path, descriptor, 0);
}

Result<OutputFile> OutputFile::create_numbered(const std::string& path) {
  for (int number = 1; number <= kMostNames; ++number) {
    auto file = create(number == 1 ? path : numbered(path, number), Existing::kKeep);
    if (file || file.error().code != ErrorCode::kInvalid) return file;
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: this name and all up to {} exist already; move them away or give another name",
                          path, numbered(path, kMostNames)));
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
    // If ftruncate() fails, the bytes after the recording's end do no harm.
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

}  // namespace copresence::file
