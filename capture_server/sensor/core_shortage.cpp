#include "capture_server/sensor/core_shortage.h"

#include <filesystem>
#include <fstream>

namespace copresence::sensor {

std::chrono::nanoseconds waited_for_a_core() {
  std::chrono::nanoseconds sum{0};
  std::error_code none;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", none)) {
    std::ifstream file(thread.path() / "schedstat");
    std::int64_t ran_ns = 0, waited_ns = 0;
    if (file >> ran_ns >> waited_ns) sum += std::chrono::nanoseconds(waited_ns);
  }
  return sum;
}

}  // namespace copresence::sensor
