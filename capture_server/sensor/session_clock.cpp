#include "capture_server/sensor/session_clock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <utility>

namespace copresence::sensor {
namespace {

// The content of the session's file: the first replay's time span in microseconds since 1970, and
// its beginning in nanoseconds of the steady clock. The file is used under a lock, so all values
// are of one machine and one boot.
struct Shared {
  std::int64_t from_us = 0, to_us = 0, begin_ns = 0;
};

constexpr std::int64_t kLongestSession = std::int64_t{1} << 55;  // In microseconds.

bool lock(int descriptor, int how) {
  int locked = -1;
  do locked = ::flock(descriptor, how);
  while (locked != 0 && errno == EINTR);
  return locked == 0;
}

bool is_sane(const Shared& shared) {
  return shared.to_us > shared.from_us && shared.from_us > -kLongestSession && shared.to_us < kLongestSession;
}

}  // namespace

std::string SessionClock::default_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime && ::access(runtime, W_OK) == 0) return runtime;
  const std::string folder = fmt::format("/tmp/copresence-{}", ::getuid());
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return {};
  struct stat status {};
  const bool is_ours =
      ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == ::getuid();
  return is_ours ? folder : std::string();
}

std::optional<SessionClock> SessionClock::join(const std::string& folder, const SessionSpan& own,
                                               Instant begin) {
  if (folder.empty() || own.to_us <= own.from_us) return std::nullopt;
  const int descriptor =
      ::open((folder + "/copresence-replay").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) return std::nullopt;
  SessionClock clock(descriptor, {own, begin}, false);
  const bool is_first = lock(descriptor, LOCK_EX | LOCK_NB);
  if (is_first) {
    const Shared mine{own.from_us, own.to_us,
                      std::chrono::duration_cast<std::chrono::nanoseconds>(begin.time_since_epoch()).count()};
    if (::pwrite(descriptor, &mine, sizeof(mine), 0) != sizeof(mine)) return std::nullopt;
  }
  // Another first replay may have started between the two locks, so the file decides in any case.
  Shared shared;
  if (!lock(descriptor, LOCK_SH) || ::pread(descriptor, &shared, sizeof(shared), 0) != sizeof(shared) ||
      !is_sane(shared)) {
    return std::nullopt;
  }
  const SessionSpan span{shared.from_us, shared.to_us};
  if (!span.overlaps(own)) return std::nullopt;
  const Instant shared_begin{std::chrono::nanoseconds(shared.begin_ns)};
  clock.is_joined_ = !is_first || shared_begin != begin;
  clock.timeline_ = SessionTimeline(span, shared_begin);
  return clock;
}

SessionClock::SessionClock(SessionClock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      timeline_(other.timeline_),
      is_joined_(other.is_joined_) {}

SessionClock& SessionClock::operator=(SessionClock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  timeline_ = other.timeline_;
  is_joined_ = other.is_joined_;
  return *this;
}

SessionClock::~SessionClock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace copresence::sensor
