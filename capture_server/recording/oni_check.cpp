#include "capture_server/recording/oni_check.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "capture_server/recording/record_bytes.h"
#include "capture_server/recording/record_walk.h"

namespace copresence::recording {
namespace {

class File {
 public:
  explicit File(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  int descriptor() const { return descriptor_; }

  bool read(std::uint64_t offset, std::span<std::uint8_t> into) const {
    while (!into.empty()) {
      const ssize_t got = ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      into = into.subspan(static_cast<std::size_t>(got));
      offset += static_cast<std::uint64_t>(got);
    }
    return true;
  }

 private:
  int descriptor_;
};

}  // namespace

const RecordedStream* RecordingSummary::find(RecordedStream::Kind kind) const {
  const auto found =
      std::find_if(streams.begin(), streams.end(), [&](const auto& s) { return s.kind == kind; });
  return found == streams.end() ? nullptr : &*found;
}

double mean_period_us(const RecordedStream& stream) {
  const auto& times = stream.timestamps_us;
  if (times.size() >= 2 && times.back() > times.front()) {
    return static_cast<double>(times.back() - times.front()) / static_cast<double>(times.size() - 1);
  }
  return 1e6 / std::max(stream.frames_per_second, 1);
}

Result<RecordingSummary> check(const std::string& path) {
  const File file(path);  // O_NONBLOCK: a named pipe must not hold us
  struct stat status {};
  if (file.descriptor() < 0 || ::fstat(file.descriptor(), &status) != 0) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: {}; give the path of an .oni recording", path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: not a file; give the path of an .oni recording", path));
  }
  RecordBytes bytes(
      static_cast<std::uint64_t>(status.st_size),
      [&](std::uint64_t offset, std::span<std::uint8_t> into) { return file.read(offset, into); });
  return RecordWalk(bytes, path).run();
}

Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name) {
  RecordBytes reader(bytes.size(), [&](std::uint64_t offset, std::span<std::uint8_t> into) {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return true;
  });
  const std::string text(name);
  return RecordWalk(reader, text).run();
}

}  // namespace copresence::recording
