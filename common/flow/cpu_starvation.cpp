#include "common/flow/cpu_starvation.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace copresence::flow {
namespace {

using std::chrono::nanoseconds;

// Returns the waiting time of each thread of a process, by thread id. The result is empty if the
// process is gone or the kernel does not count.
std::map<pid_t, nanoseconds> waits_of(const std::string& process) {
  std::map<pid_t, nanoseconds> waits;
  std::error_code none;
  std::filesystem::directory_iterator threads("/proc/" + process + "/task", none);
  for (; !none && threads != std::filesystem::directory_iterator(); threads.increment(none)) {
    const std::string name = threads->path().filename();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    std::ifstream file(threads->path() / "schedstat");
    std::int64_t ran_ns = 0, waited_ns = 0;
    if (file >> ran_ns >> waited_ns) waits[thread] = nanoseconds(waited_ns);
  }
  return waits;
}

}  // namespace

nanoseconds CpuStarvation::look() {
  auto now = waits_of(std::to_string(process_));
  if (std::exchange(has_looked_, true)) {
    for (const auto& [thread, waited] : now) {
      const auto before = threads_.find(thread);
      sum_ += before == threads_.end() ? waited : std::max(waited - before->second, nanoseconds(0));
    }
  }
  threads_ = std::move(now);
  return sum_;
}

}  // namespace copresence::flow
