#pragma once

// A room that runs: capture servers on recordings, and clients that look at it.

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace copresence::testing {

class RunningRoom {
 public:
  using Arguments = std::vector<std::string>;

  /// Starts a server on a recording at a free port; `more` are further arguments, `environment` as for Process. Returns
  /// its index.
  std::size_t serve(const std::filesystem::path& recording, const Arguments& more = {},
                    const Arguments& environment = {});

  Process& server(std::size_t index) { return *servers_[index]; }
  std::string address(std::size_t index) const;
  void kill_server(std::size_t index);
  /// Starts the same server again at the same port.
  void restart_server(std::size_t index);

  /// A headless client of all servers, started; it writes stats() and picture().
  Process& look(const Arguments& more);

  /// Runs a headless client to its end and expects that it succeeds within a minute.
  nlohmann::json view(const Arguments& more);

  nlohmann::json stats() const;
  std::filesystem::path picture() const { return folder_ / "view.png"; }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

 private:
  std::string outputs_of_servers() const;

  TemporaryFolder folder_;
  std::vector<Arguments> started_;
  std::vector<int> ports_;
  std::vector<std::unique_ptr<Process>> servers_;
  std::vector<std::unique_ptr<Process>> clients_;
};

}  // namespace copresence::testing
