#pragma once

// A virtual X server without a screen (Xvfb) for one test. Window tests then run anywhere and do
// not disturb the user's desktop. Sets DISPLAY as long as it exists.

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

namespace copresence {

class VirtualDisplay {
 public:
  VirtualDisplay() {
    int ends[2];
    if (pipe(ends) != 0) return;
    server_ = fork();
    if (server_ == 0) {
      close(ends[0]);
      const int null = open("/dev/null", O_WRONLY);
      dup2(null, STDERR_FILENO);
      const std::string number = std::to_string(ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1280x800x24", "-nolisten", "tcp",
             "-noreset", nullptr);
      _exit(127);
    }
    close(ends[1]);
    // The server writes its display number once it accepts connections. If it cannot start, the
    // pipe ends without data.
    std::string number;
    for (char digit = 0; read(ends[0], &digit, 1) == 1 && digit != '\n';) number += digit;
    close(ends[0]);
    if (number.empty()) return;
    unsetenv("WAYLAND_DISPLAY");
    setenv("DISPLAY", (":" + number).c_str(), 1);
    is_there_ = true;
  }

  ~VirtualDisplay() {
    if (server_ <= 0) return;
    kill(server_, SIGTERM);
    waitpid(server_, nullptr, 0);
    unsetenv("DISPLAY");
  }

  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  bool is_there() const { return is_there_; }  ///< False if Xvfb is not installed.

 private:
  pid_t server_ = -1;
  bool is_there_ = false;
};

}  // namespace copresence
