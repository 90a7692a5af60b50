#pragma once

// A progress bar on standard error. It is shown only on a terminal.

#include <string>

namespace copresence::tools {

class Progress {
 public:
  /// `runs` is the number of begin() calls of the whole run.
  explicit Progress(int runs);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Begins the next step; `what` is shown next to the bar.
  void begin(const std::string& what);
  /// Removes the bar before other output.
  void clear();

 private:
  int runs_, begun_ = 0;
  bool is_terminal_;
};

}  // namespace copresence::tools
