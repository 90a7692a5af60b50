#include "capture_server/supervisor.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace copresence {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

// The signals that a parent waits for instead of being interrupted by them.
class BlockedSignals {
 public:
  explicit BlockedSignals(bool hangup_too) {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGTERM, SIGINT, SIGCHLD}) sigaddset(&set, signal);
    if (hangup_too) sigaddset(&set, SIGHUP);
    sigprocmask(SIG_BLOCK, &set, &before_);
    for_children_ = before_;
    if (hangup_too) sigaddset(&for_children_, SIGHUP);
    descriptor_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  }
  ~BlockedSignals() {
    ::close(descriptor_);
    sigprocmask(SIG_SETMASK, &before_, nullptr);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

  void restore_in_child() const { sigprocmask(SIG_SETMASK, &for_children_, nullptr); }
  int descriptor() const { return descriptor_; }

  struct Come {
    bool stop = false, hangup = false;
  };
  Come take() const {
    Come come;
    signalfd_siginfo got;
    while (::read(descriptor_, &got, sizeof(got)) == sizeof(got)) {
      come.stop = come.stop || got.ssi_signo == SIGTERM || got.ssi_signo == SIGINT;
      come.hangup = come.hangup || got.ssi_signo == SIGHUP;
    }
    return come;
  }

 private:
  sigset_t before_, for_children_;
  int descriptor_ = -1;
};

// How one child ended.
struct End {
  enum class Kind { kExited, kStopped, kCrashed, kHung, kWouldNotStop };
  Kind kind = Kind::kExited;
  int code = 0;  // exit status, or signal, or milliseconds of silence
};

int poll_ms(Clock::time_point until) {
  const auto left = std::chrono::ceil<milliseconds>(until - Clock::now()).count();
  return static_cast<int>(std::clamp<long>(left, 0, 60'000));
}

class Child {
 public:
  Child(const SupervisorPolicy& policy, const BlockedSignals& signals,
        const std::function<int(Heartbeat&)>& child_main, bool replaces_another)
      : policy_(policy), signals_(signals) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return;
    read_end_.emplace(ends[0]);
    Descriptor write_end(ends[1]);
    const pid_t parent = ::getpid();
    std::fflush(nullptr);  // or both processes write what is still buffered
    id_ = ::fork();
    if (id_ != 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(1);  // it died before the line above
    read_end_->close();
    signals_.restore_in_child();
    Heartbeat heartbeat(write_end.number(), replaces_another);
    std::exit(child_main(heartbeat));
  }

  bool began() const { return id_ > 0; }

  End wait() {
    const auto patience = [&] { return heard_ ? policy_.silence : policy_.first_silence; };
    auto deadline = Clock::now() + patience();
    bool stopping = false;
    while (true) {
      pollfd watched[] = {{read_end_->number(), POLLIN, 0}, {signals_.descriptor(), POLLIN, 0}};
      ::poll(watched, 2, poll_ms(deadline));
      const auto come = signals_.take();
      if (come.hangup) ::kill(id_, SIGHUP);
      if (come.stop && !stopping) {
        stopping = true;
        deadline = Clock::now() + policy_.stop_within;
        ::kill(id_, SIGTERM);
      }
      int status = 0;
      if (::waitpid(id_, &status, WNOHANG) == id_) return ended(status, stopping);
      if (drain() && !stopping) {
        heard_ = true;
        deadline = Clock::now() + patience();
      }
      if (Clock::now() >= deadline) {
        ::kill(id_, SIGKILL);
        ::waitpid(id_, &status, 0);
        return stopping ? End{End::Kind::kWouldNotStop, SIGKILL}
                        : End{End::Kind::kHung, static_cast<int>(patience().count())};
      }
    }
  }

 private:
  static End ended(int status, bool stopping) {
    if (WIFEXITED(status)) return {End::Kind::kExited, WEXITSTATUS(status)};
    const int signal = WTERMSIG(status);
    return {stopping && signal == SIGTERM ? End::Kind::kStopped : End::Kind::kCrashed, signal};
  }

  // Whether there were heartbeats. A closed pipe stays readable, but its writer is about to be waited for.
  bool drain() {
    char beats[256];
    bool any = false;
    ssize_t got;
    while ((got = ::read(read_end_->number(), beats, sizeof(beats))) > 0) any = true;
    if (got == 0) ::usleep(1000);
    return any;
  }

  const SupervisorPolicy& policy_;
  const BlockedSignals& signals_;
  std::optional<Descriptor> read_end_;
  pid_t id_ = -1;
  bool heard_ = false;
};

std::string what_happened(const SupervisorPolicy& policy, const End& end) {
  switch (end.kind) {
    case End::Kind::kHung:
      return fmt::format("{}: capturing hung, no sign of life for {:.1f} s", policy.subject,
                         static_cast<double>(end.code) / 1000);
    case End::Kind::kWouldNotStop:
      return fmt::format("{}: capturing did not stop within {:.1f} s and was killed", policy.subject,
                         static_cast<double>(policy.stop_within.count()) / 1000);
    default:
      return fmt::format("{}: capturing crashed ({})", policy.subject, ::strsignal(end.code));
  }
}

void say(const std::string& sentence) {
  fmt::print(stderr, "{}\n", sentence);
  std::fflush(stderr);
}

// True where a stop came meanwhile.
bool pause(const BlockedSignals& signals, milliseconds length) {
  const auto until = Clock::now() + length;
  while (Clock::now() < until) {
    pollfd watched{signals.descriptor(), POLLIN, 0};
    ::poll(&watched, 1, poll_ms(until));
    if (signals.take().stop) return true;  // a new child reads what SIGHUP is about by itself
  }
  return false;
}

}  // namespace

void Heartbeat::beat() {
  const char beat = 1;
  // A full pipe has beats enough in it; a broken one has no parent, and then there is no child for long
  // either.
  [[maybe_unused]] const ssize_t written = ::write(pipe_, &beat, 1);
}

int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main) {
  const BlockedSignals signals(policy.passes_hangup);
  milliseconds next_pause = policy.first_pause;
  int in_a_row = 0;
  bool replaces_another = false;
  while (true) {
    const auto begin = Clock::now();
    Child child(policy, signals, child_main, replaces_another);
    replaces_another = true;
    if (!child.began()) {
      say(fmt::format("{}: no process for capturing: {}; end other programs", policy.subject,
                      std::strerror(errno)));
      return 1;
    }
    const End end = child.wait();
    if (end.kind == End::Kind::kExited) return end.code;
    if (end.kind == End::Kind::kStopped) return 0;
    if (end.kind == End::Kind::kWouldNotStop) {
      say(what_happened(policy, end));
      return 1;
    }
    if (!policy.restart) {
      say(what_happened(policy, end) + ", so it is damaged where its check does not see it; record it again");
      return 1;
    }
    if (Clock::now() - begin >= policy.healthy_after) {
      in_a_row = 0;
      next_pause = policy.first_pause;
    }
    if (++in_a_row >= policy.most_in_a_row) {
      say(what_happened(policy, end) +
          fmt::format(", {} times in a row; unplug the camera and start again", in_a_row));
      return 1;
    }
    say(what_happened(policy, end) + "; starting it again");
    if (pause(signals, next_pause)) return 0;
    next_pause = std::min(2 * next_pause, policy.longest_pause);
  }
}

}  // namespace copresence
