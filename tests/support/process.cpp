#include "tests/support/process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

namespace copresence::testing {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::filesystem::path program(const std::string& name) {
  return std::filesystem::path(COPRESENCE_PROGRAMS) / name;
}

std::filesystem::path recordings() {
  return std::filesystem::path(COPRESENCE_ROOT) / "data/recordings";
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "copresence-XXXXXX").string();
  if (!mkdtemp(pattern.data())) ADD_FAILURE() << "no temporary folder can be made";
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  bind(socket, reinterpret_cast<sockaddr*>(&address), size);
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  close(socket);
  return ntohs(address.sin_port);
}

Process::Process(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  const std::string output = (folder_ / "output").string();
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
    execv(argv[0], argv.data());
    _exit(127);
  }
  setpgid(pid_, pid_);  // Parent and child both do this, because signal_group() must find the group.
}

Process::~Process() {
  if (pid_ > 0) kill(-pid_, SIGKILL);
  if (!exit_code_) wait(milliseconds(5000));
}

void Process::signal(int number) const {
  kill(pid_, number);
}

void Process::signal_group(int number) const {
  kill(-pid_, number);
}

pid_t Process::child() const {
  const std::string id = std::to_string(pid_);
  const auto deadline = steady_clock::now() + std::chrono::seconds(10);
  while (steady_clock::now() < deadline) {
    std::ifstream file("/proc/" + id + "/task/" + id + "/children");
    if (pid_t child = 0; file >> child) return child;
    std::this_thread::sleep_for(milliseconds(2));
  }
  ADD_FAILURE() << "process " << id << " has no child";
  return -1;
}

std::optional<int> Process::wait(milliseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  while (!exit_code_) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    } else if (steady_clock::now() >= deadline) {
      return std::nullopt;
    } else {
      std::this_thread::sleep_for(milliseconds(5));
    }
  }
  return exit_code_;
}

std::string Process::output() const {
  std::ifstream file(folder_ / "output");
  return {std::istreambuf_iterator<char>(file), {}};
}

bool Process::says(const std::string& text, milliseconds timeout) const {
  const auto deadline = steady_clock::now() + timeout;
  while (output().find(text) == std::string::npos) {
    if (steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return true;
}

}  // namespace copresence::testing
