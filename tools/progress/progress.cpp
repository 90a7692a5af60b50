#include "tools/progress/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace copresence::tools {

Progress::Progress(int runs) : runs_(runs), is_terminal_(isatty(STDERR_FILENO) != 0) {}
Progress::~Progress() {
  clear();
}

void Progress::begin(const std::string& what) {
  constexpr int kWidth = 30;
  const int done = runs_ > 0 ? kWidth * begun_ / runs_ : 0;
  ++begun_;
  if (!is_terminal_) return;
  fmt::print(stderr, "\r\033[K[{:<{}}] {}/{} {}", std::string(static_cast<std::size_t>(done), '#'), kWidth,
             begun_, runs_, what);
  std::fflush(stderr);
}

void Progress::clear() {
  if (!is_terminal_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

}  // namespace copresence::tools
