#pragma once

// A progress bar on standard error, shown only on a terminal.

#include <string>

namespace copresence::tools {

class Progress {
 public:
  /// `runs` is the total number of begin() calls.
  explicit Progress(int runs);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Begins the next step. The bar shows `what` beside it.
  void begin(const std::string& what);
  /// Removes the bar before other output.
  void clear();

 private:
  int runs_, begun_ = 0;
  bool is_terminal_;
};

}  // namespace copresence::tools
