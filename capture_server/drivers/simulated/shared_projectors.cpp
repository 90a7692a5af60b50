#include "capture_server/drivers/simulated/shared_projectors.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <utility>

namespace copresence::drivers {
namespace {

constexpr std::size_t kBytes = simulation::kMostKinects * sizeof(std::uint32_t);

bool is_alive(std::uint32_t process) {
  return process != 0 && (::kill(static_cast<pid_t>(process), 0) == 0 || errno == EPERM);
}

}  // namespace

Result<SharedProjectors> SharedProjectors::open(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  // ftruncate() keeps the content of a file that already has this size.
  const bool sized = file >= 0 && ::ftruncate(file, kBytes) == 0;
  void* const mapped =
      sized ? ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  const std::string why = std::strerror(errno);
  if (file >= 0) ::close(file);
  if (mapped == MAP_FAILED) return fail(ErrorCode::kUnavailable, path + ": " + why + "; give another file");
  return SharedProjectors(static_cast<std::uint32_t*>(mapped));
}

SharedProjectors::SharedProjectors(SharedProjectors&& other) noexcept
    : entries_(std::exchange(other.entries_, nullptr)) {}

SharedProjectors::~SharedProjectors() {
  if (entries_) ::munmap(entries_, kBytes);
}

void SharedProjectors::set(std::size_t camera, bool is_on) {
  assert(camera < simulation::kMostKinects);
  std::atomic_ref(entries_[camera]).store(is_on ? static_cast<std::uint32_t>(::getpid()) : 0);
}

simulation::Projectors SharedProjectors::on() const {
  simulation::Projectors state;
  for (std::size_t i = 0; i < simulation::kMostKinects; ++i)
    state[i] = is_alive(std::atomic_ref(entries_[i]).load());
  return state;
}

}  // namespace copresence::drivers
