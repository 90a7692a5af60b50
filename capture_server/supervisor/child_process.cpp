#include "capture_server/supervisor/child_process.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <utility>

#include "capture_server/supervisor/crash_history.h"

namespace copresence::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kBetweenLooks{100}, kBetweenLooksWhileStopping{20};
constexpr int kStarvedSilence = 6;  // A child without CPU may be silent this many times longer.
constexpr milliseconds kKilledWithin{2000};

double seconds(nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

bool is_fatal(int signal) {
  constexpr std::array kFatal{SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS};
  return std::find(kFatal.begin(), kFatal.end(), signal) != kFatal.end();
}

// True if a signal ('T') or a debugger ('t') has suspended the process.
bool is_suspended(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(file, line);
  const auto name_ends = line.rfind(") ");
  if (name_ends == std::string::npos || name_ends + 2 >= line.size()) return false;
  const char state = line[name_ends + 2];
  return state == 'T' || state == 't';
}

}  // namespace

BlockedSignals::BlockedSignals(bool hangup_too) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGCHLD}) sigaddset(&set, signal);
  if (hangup_too) sigaddset(&set, SIGHUP);
  sigprocmask(SIG_BLOCK, &set, &before_);
  for_children_ = before_;
  if (hangup_too) sigaddset(&for_children_, SIGHUP);
  descriptor_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

BlockedSignals::~BlockedSignals() {
  ::close(descriptor_);
  sigprocmask(SIG_SETMASK, &before_, nullptr);
}

void BlockedSignals::restore_in_child() const {
  ::signal(SIGINT, SIG_IGN);
  sigprocmask(SIG_SETMASK, &for_children_, nullptr);
}

BlockedSignals::Arrived BlockedSignals::wait(milliseconds time) const {
  pollfd watched{descriptor_, POLLIN, 0};
  ::poll(&watched, 1, static_cast<int>(time.count()));
  Arrived arrived;
  signalfd_siginfo got;
  while (::read(descriptor_, &got, sizeof(got)) == sizeof(got)) {
    arrived.interrupt = arrived.interrupt || got.ssi_signo == SIGINT;
    arrived.stop = arrived.stop || arrived.interrupt || got.ssi_signo == SIGTERM;
    arrived.hangup = arrived.hangup || got.ssi_signo == SIGHUP;
  }
  return arrived;
}

SharedReport::SharedReport()
    : memory_(
          ::mmap(nullptr, sizeof(ChildReport), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {}

SharedReport::~SharedReport() {
  if (has_memory()) ::munmap(memory_, sizeof(ChildReport));
}

bool SharedReport::has_memory() const {
  return memory_ != MAP_FAILED;
}

ChildReport& SharedReport::begin_anew() {
  return *new (memory_) ChildReport();
}

bool Countdown::is_over(nanoseconds step, nanoseconds usual, nanoseconds most,
                        const std::function<nanoseconds()>& starved) {
  passed_ += step;
  if (passed_ < usual / 4) return false;
  const nanoseconds now = starved();
  if (!starved_before_) starved_before_ = now;
  return flow::StallTimeout(usual, most).is_over(passed_, now - *starved_before_);
}

ChildProcess::ChildProcess(const SupervisorPolicy& policy, const BlockedSignals& signals, ChildReport& report,
                           const Predecessor& predecessor, const std::function<int(Heartbeat&)>& child_main)
    : policy_(policy), signals_(signals), report_(report) {
  const pid_t parent = ::getpid();
  std::fflush(nullptr);  // Otherwise both processes would write the buffered text.
  id_ = ::fork();
  if (id_ != 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) std::_Exit(1);  // The parent died before prctl().
  Heartbeat heartbeat(report_, predecessor);
  heartbeat.note_crashes();
  signals_.restore_in_child();
  std::exit(child_main(heartbeat));
}

ChildEnd ChildProcess::wait() {
  if (id_ < 0) return {.kind = ChildEnd::Kind::kNotStarted, .code = errno};
  flow::CpuStarvation account(id_);
  starved_ = policy_.starvation ? [this] { return policy_.starvation(id_); }
                                : std::function<nanoseconds()>([&account] { return account.look(); });
  flow::WatchedTime time;
  auto last = time.look(nanoseconds(0));  // The previous value of `time`.
  while (true) {
    const milliseconds look = between_looks();
    const auto arrived = signals_.wait(look);
    // This process may have been suspended or without CPU. So the step is limited to twice the
    // intended time between two checks.
    const auto now = time.look(2 * look);
    const nanoseconds step = now - std::exchange(last, now);
    if (arrived.hangup) ::kill(id_, SIGHUP);
    if (arrived.interrupt && stop_asked_at_ && Clock::now() - *stop_asked_at_ >= policy_.second_stop_after) {
      kill_at_once();
      return describe(ChildEnd::Kind::kStoppedAtOnce, SIGINT);
    }
    if (arrived.stop && !stop_asked_at_) ask_to_stop();
    if (const auto end = reap()) return *end;
    if (suspended_) {
      resume_after(step);
    } else if (stop_asked_at_) {
      if (!stopping_.is_over(step, policy_.stop_within, policy_.stop_starved, starved_)) continue;
      kill_at_once();
      return describe(ChildEnd::Kind::kWouldNotStop, SIGKILL);
    } else if (auto hung = look_at_threads(step)) {
      kill_at_once();
      return *hung;
    }
  }
}

milliseconds ChildProcess::between_looks() const {
  const milliseconds most = stop_asked_at_ ? kBetweenLooksWhileStopping : kBetweenLooks;
  return std::clamp(policy_.silence / 10, milliseconds(1), most);
}

void ChildProcess::ask_to_stop() {
  stop_asked_at_ = Clock::now();
  stopping_.begin_again(starved_());
  ::kill(id_, SIGTERM);
  ::kill(id_, SIGCONT);  // A suspended child does not receive the SIGTERM.
}

std::optional<ChildEnd> ChildProcess::reap() {
  int status = 0;
  while (::waitpid(id_, &status, WNOHANG | WUNTRACED | WCONTINUED) == id_) {
    if (WIFSTOPPED(status)) {
      suspended_ = true;
      suspension_ = nanoseconds(0);
      if (stop_asked_at_) ::kill(id_, SIGCONT);
    } else if (WIFCONTINUED(status)) {
      suspended_ = false;
      forget_silence();
    } else {
      return ended(status);
    }
  }
  return std::nullopt;
}

ChildEnd ChildProcess::ended(int status) {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  const pid_t sender = report_.fatal_signal == signal ? report_.sender.load() : 0;
  const bool own_crash = is_fatal(signal) && (sender == 0 || sender == id_);
  if (stop_asked_at_) {
    const bool by_itself = WIFEXITED(status) && WEXITSTATUS(status) != kEndedBySignal;
    ChildEnd end = describe(by_itself ? ChildEnd::Kind::kExited : ChildEnd::Kind::kStopped,
                            by_itself ? WEXITSTATUS(status) : signal);
    end.crash = own_crash;
    return end;
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) != kEndedBySignal)
    return describe(ChildEnd::Kind::kExited, WEXITSTATUS(status));
  if (WIFEXITED(status)) {
    ChildEnd end = describe(ChildEnd::Kind::kKilled, SIGTERM);
    end.stage = Stage::kRunning;  // The child was running and ended only because of the signal.
    return end;
  }
  ChildEnd end = describe(own_crash ? ChildEnd::Kind::kCrashed : ChildEnd::Kind::kKilled, signal);
  end.sender = sender;
  return end;
}

ChildEnd ChildProcess::describe(ChildEnd::Kind kind, int code) const {
  ChildEnd end{.kind = kind, .code = code};
  end.stage = report_.stage;
  end.activity = report_.activity.get();
  end.remedy = report_.remedy.get();
  end.frames = report_.frames;
  end.thread = report_.crashed_thread.get();
  const bool begun = end.stage == Stage::kRunning || end.stage == Stage::kEnding;
  if (begun && end.activity.empty() && opens_or_closes()) end.activity = "opening or closing its source";
  return end;
}

bool ChildProcess::opens_or_closes() const {
  return std::any_of(report_.threads.begin(), report_.threads.end(),
                     [](const ChildReport::Thread& thread) { return thread.pace == Pace::kOpening; });
}

void ChildProcess::resume_after(nanoseconds step) {
  suspension_ += step;
  if (suspension_ < policy_.silence) return;
  say(fmt::format("{}: capture was suspended by another process's signal for {:.1f} s; resuming it",
                  policy_.subject, seconds(suspension_)));
  suspension_ = nanoseconds(0);
  ::kill(id_, SIGCONT);
}

void ChildProcess::forget_silence() {
  for (Watched& thread : watched_) thread.silence.begin_again();
}

std::optional<ChildEnd> ChildProcess::look_at_threads(nanoseconds step) {
  const std::size_t used = std::min<std::size_t>(report_.threads_used, ChildReport::kMostThreads);
  for (std::size_t i = 0; i < used; ++i) {
    ChildReport::Thread& thread = report_.threads[i];
    Watched& watched = watched_[i];
    const std::uint64_t beats = thread.beats;
    const Pace pace = thread.pace;
    if (std::exchange(watched.beats, beats) != beats || pace == Pace::kResting || pace == Pace::kUnused) {
      watched.silence.begin_again();
      continue;
    }
    const milliseconds usual = pace == Pace::kOpening ? policy_.opening : policy_.silence;
    if (!watched.silence.is_over(step, usual, kStarvedSilence * usual, starved_)) continue;
    if (is_suspended(id_)) {  // A debugger suspended the child. waitpid() reports a suspension by a signal.
      watched.silence.begin_again();
      continue;
    }
    ChildEnd end = describe(ChildEnd::Kind::kHung, 0);
    end.thread = thread.name.get();
    end.silent = watched.silence.passed();
    return end;
  }
  return std::nullopt;
}

// Kills the child and waits at most kKilledWithin for its end, because a process that waits for a
// device cannot be killed.
void ChildProcess::kill_at_once() const {
  ::kill(id_, SIGKILL);
  for (const auto until = Clock::now() + kKilledWithin; Clock::now() < until;) {
    if (::waitpid(id_, nullptr, WNOHANG) == id_) return;
    ::usleep(2000);
  }
  say(fmt::format(
      "{}: process {} does not end although it was killed: a disk or a USB device does not answer the "
      "system",
      policy_.subject, id_));
}

}  // namespace copresence::server
