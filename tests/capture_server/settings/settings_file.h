#pragma once

// A settings file and the command line that names it.

#include <fstream>
#include <string>
#include <vector>

#include "capture_server/settings.h"
#include "tests/support/process.h"

namespace copresence::server {

class SettingsFile {
 public:
  explicit SettingsFile(const std::string& text) { write(text); }

  void write(const std::string& text) const { std::ofstream(path()) << text; }
  std::string path() const { return (folder_ / "desk.toml").string(); }
  std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }

  /// capture_server --config FILE and more.
  std::vector<const char*> with(std::vector<const char*> more = {}) {
    path_ = path();
    std::vector<const char*> all{"capture_server", "--config", path_.c_str()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

 private:
  testing::TemporaryFolder folder_;
  std::string path_;
};

}  // namespace copresence::server
