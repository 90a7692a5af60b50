#include "capture_server/sensor/read_position.h"

#include <sys/stat.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>

namespace copresence::sensor {

std::uint64_t read_position_beside(int descriptor) {
  struct stat ours {};
  if (::fstat(descriptor, &ours) != 0) return 0;
  std::uint64_t sum = 0;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fdinfo", none)) {
    const std::string name = entry.path().filename();
    int number = -1;
    std::from_chars(name.data(), name.data() + name.size(), number);
    // By its name: the descriptor itself is another thread's, which may open or close it at this moment.
    struct stat its {};
    if (number == descriptor || ::stat(("/proc/self/fd/" + name).c_str(), &its) != 0) continue;
    if (its.st_dev != ours.st_dev || its.st_ino != ours.st_ino) continue;
    std::ifstream file(entry.path());
    std::string word;
    std::uint64_t position = 0;
    if (file >> word >> position && word == "pos:") sum += position;
  }
  return sum;
}

}  // namespace copresence::sensor
