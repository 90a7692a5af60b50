#pragma once

// A bar on standard error that says how far a long run has come; nothing where no person watches.

#include <string>

namespace copresence::tools {

class Progress {
 public:
  explicit Progress(int runs);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(const std::string& what);  ///< the next run
  void clear();                         ///< makes room for a line of output

 private:
  int runs_, begun_ = 0;
  bool watched_;
};

}  // namespace copresence::tools
