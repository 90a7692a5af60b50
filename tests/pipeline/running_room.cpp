#include "tests/pipeline/running_room.h"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

namespace copresence::testing {

using std::chrono::seconds;

std::size_t RunningRoom::serve(const std::filesystem::path& recording, const Arguments& more,
                               const Arguments& environment) {
  ports_.push_back(free_port());
  Arguments arguments{program("capture_server"), "--source", recording, "--listen",
                      address(ports_.size() - 1)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  started_.push_back(arguments);
  servers_.push_back(std::make_unique<Process>(arguments, environment));
  return servers_.size() - 1;
}

std::string RunningRoom::address(std::size_t index) const {
  return "127.0.0.1:" + std::to_string(ports_[index]);
}

void RunningRoom::kill_server(std::size_t index) {
  servers_[index]->signal_group(SIGKILL);
  servers_[index]->wait(seconds(5));
}

void RunningRoom::restart_server(std::size_t index) {
  servers_[index] = std::make_unique<Process>(started_[index]);
}

Process& RunningRoom::look(const Arguments& more) {
  Arguments arguments{program("render_client"), "--headless",   "--stats",
                      file("stats.json"),       "--screenshot", picture()};
  for (std::size_t i = 0; i < ports_.size(); ++i)
    arguments.insert(arguments.end(), {"--connect", address(i)});
  arguments.insert(arguments.end(), more.begin(), more.end());
  clients_.push_back(std::make_unique<Process>(arguments));
  return *clients_.back();
}

nlohmann::json RunningRoom::view(const Arguments& more) {
  Process& client = look(more);
  const auto ended = client.wait(seconds(60));
  EXPECT_EQ(ended, 0) << client.output() << outputs_of_servers();
  return ended == 0 ? stats() : nlohmann::json();
}

std::string RunningRoom::outputs_of_servers() const {
  std::string all;
  for (const auto& server : servers_) all += server ? server->output() : "";
  return all;
}

nlohmann::json RunningRoom::stats() const {
  std::ifstream file(folder_ / "stats.json");
  return nlohmann::json::parse(file, nullptr, false);
}

}  // namespace copresence::testing
