#include "common/flow/thread_priority.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <string>

namespace copresence::flow {
namespace {

void lower(pid_t thread, int steps) {
  const auto id = static_cast<id_t>(thread);
  setpriority(PRIO_PROCESS, id, getpriority(PRIO_PROCESS, id) + steps);
}

std::set<pid_t> threads_now() {
  std::set<pid_t> threads;
  std::error_code none;
  std::filesystem::directory_iterator entries("/proc/self/task", none);
  for (; !none && entries != std::filesystem::directory_iterator(); entries.increment(none)) {
    const std::string name = entries->path().filename();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    threads.insert(thread);
  }
  return threads;
}

}  // namespace

void lower_priority(int steps) {
  lower(static_cast<pid_t>(syscall(SYS_gettid)), steps);
}

NewThreads::NewThreads() : before_(threads_now()) {}

void NewThreads::lower_priority(int steps) const {
  for (const pid_t thread : threads_now()) {
    if (!before_.contains(thread)) lower(thread, steps);
  }
}

}  // namespace copresence::flow
