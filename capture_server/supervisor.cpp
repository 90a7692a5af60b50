#include "capture_server/supervisor.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <new>
#include <optional>

#include "capture_server/sensor/cpu_starvation.h"

namespace copresence {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kBetweenLooks{100}, kBetweenLooksWhileStopping{20};
constexpr int kStarvedSilence = 6;  // times the usual limit: see SupervisorPolicy
constexpr milliseconds kKilledWithin{2000};

// The signals that the parent waits for instead of being interrupted by them.
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

  // SIGINT is ignored before it is let in: a Ctrl-C that came meanwhile is the parent's to hand on.
  void restore_in_child() const {
    ::signal(SIGINT, SIG_IGN);
    sigprocmask(SIG_SETMASK, &for_children_, nullptr);
  }

  struct Arrived {
    bool stop = false;       // SIGTERM or SIGINT
    bool interrupt = false;  // SIGINT
    bool hangup = false;
  };

  // What has arrived after at most `time`; the end of a child ends the wait as well.
  Arrived wait(milliseconds time) const {
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

 private:
  sigset_t before_, for_children_;
  int descriptor_ = -1;
};

// A ChildReport that parent and children share. Each child begins with a new one.
class SharedReport {
 public:
  SharedReport()
      : memory_(::mmap(nullptr, sizeof(ChildReport), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
                       0)) {}
  ~SharedReport() {
    if (has_memory()) ::munmap(memory_, sizeof(ChildReport));
  }
  SharedReport(const SharedReport&) = delete;
  SharedReport& operator=(const SharedReport&) = delete;

  bool has_memory() const { return memory_ != MAP_FAILED; }
  ChildReport& begin_anew() { return *new (memory_) ChildReport(); }

 private:
  void* memory_;
};

// How one child ended.
struct End {
  enum class Kind {
    kNotBegun,
    kExited,
    kStopped,        // asked to, by whatever way
    kWouldNotStop,   // ... and killed for it
    kStoppedAtOnce,  // ... and killed on a second request
    kCrashed,        // by itself
    kKilled,         // by somebody else's signal
    kHung,
  };
  Kind kind = Kind::kExited;
  int code = 0;        // exit status, or the signal's number
  bool crash = false;  // of one that was asked to stop
  Stage stage = Stage::kPreparing;
  std::string activity{}, remedy{};
  std::uint64_t frames = 0;
  std::string thread{};   // that crashed or hung; empty where nobody knows
  pid_t sender = 0;       // of the signal that killed; 0 where nobody knows
  nanoseconds silent{0};  // of one that hung
};

bool is_fatal(int signal) {
  constexpr std::array kFatal{SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS};
  return std::find(kFatal.begin(), kFatal.end(), signal) != kFatal.end();
}

double seconds(nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

void say(const std::string& sentence) {
  fmt::print(stderr, "{}\n", sentence);
  std::fflush(stderr);
}

// Suspended by a signal ('T') or by a debugger ('t').
bool is_suspended(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(file, line);
  const auto name_ends = line.rfind(") ");
  if (name_ends == std::string::npos || name_ends + 2 >= line.size()) return false;
  const char state = line[name_ends + 2];
  return state == 'T' || state == 't';
}

// One deadline that is extended by the time in which the child got no core.
class Countdown {
 public:
  void begin_again(std::optional<nanoseconds> starved_before = std::nullopt) {
    passed_ = nanoseconds(0);
    starved_before_ = starved_before;
  }
  nanoseconds passed() const { return passed_; }

  // Whether it is over after `step` more. The child's starvation is looked at only when it may matter.
  bool is_over(nanoseconds step, nanoseconds usual, nanoseconds most,
               const std::function<nanoseconds()>& starved) {
    passed_ += step;
    if (passed_ < usual / 4) return false;
    const nanoseconds now = starved();
    if (!starved_before_) starved_before_ = now;
    return sensor::StallTimeout(usual, most).is_over(passed_, now - *starved_before_);
  }

 private:
  nanoseconds passed_{0};
  std::optional<nanoseconds> starved_before_;
};

class Child {
 public:
  Child(const SupervisorPolicy& policy, const BlockedSignals& signals, ChildReport& report,
        const Predecessor& predecessor, const std::function<int(Heartbeat&)>& child_main)
      : policy_(policy), signals_(signals), report_(report) {
    const pid_t parent = ::getpid();
    std::fflush(nullptr);  // or both processes write what is still buffered
    id_ = ::fork();
    if (id_ != 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(1);  // it died before the line above
    Heartbeat heartbeat(report_, predecessor);
    heartbeat.note_crashes();
    signals_.restore_in_child();
    std::exit(child_main(heartbeat));
  }

  End wait() {
    if (id_ < 0) return {.kind = End::Kind::kNotBegun, .code = errno};
    sensor::CpuStarvation account(id_);
    starved_ = policy_.starvation ? [this] { return policy_.starvation(id_); }
                                  : std::function<nanoseconds()>([&account] { return account.look(); });
    sensor::WatchedTime time;
    auto last = time.look(nanoseconds(0));  // of `time`
    while (true) {
      const milliseconds look = between_looks();
      const auto arrived = signals_.wait(look);
      // A look that comes late, since this process was suspended or got no core, counts no more than twice.
      const auto now = time.look(2 * look);
      const nanoseconds step = now - std::exchange(last, now);
      if (arrived.hangup) ::kill(id_, SIGHUP);
      if (arrived.interrupt && stop_asked_at_ &&
          Clock::now() - *stop_asked_at_ >= policy_.second_stop_after) {
        kill_at_once();
        return describe(End::Kind::kStoppedAtOnce, SIGINT);
      }
      if (arrived.stop && !stop_asked_at_) ask_to_stop();
      if (const auto end = reap()) return *end;
      if (suspended_) {
        resume_after(step);
      } else if (stop_asked_at_) {
        if (!stopping_.is_over(step, policy_.stop_within, policy_.stop_starved, starved_)) continue;
        kill_at_once();
        return describe(End::Kind::kWouldNotStop, SIGKILL);
      } else if (auto hung = look_at_threads(step)) {
        kill_at_once();
        return *hung;
      }
    }
  }

 private:
  milliseconds between_looks() const {
    const milliseconds most = stop_asked_at_ ? kBetweenLooksWhileStopping : kBetweenLooks;
    return std::clamp(policy_.silence / 10, milliseconds(1), most);
  }

  void ask_to_stop() {
    stop_asked_at_ = Clock::now();
    stopping_.begin_again(starved_());
    ::kill(id_, SIGTERM);
    ::kill(id_, SIGCONT);  // one that is suspended would not hear of it
  }

  std::optional<End> reap() {
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

  End ended(int status) {
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    const pid_t sender = report_.fatal_signal == signal ? report_.sender.load() : 0;
    const bool own_crash = is_fatal(signal) && (sender == 0 || sender == id_);
    if (stop_asked_at_) {
      const bool by_itself = WIFEXITED(status) && WEXITSTATUS(status) != kEndedBySignal;
      End end = describe(by_itself ? End::Kind::kExited : End::Kind::kStopped,
                         by_itself ? WEXITSTATUS(status) : signal);
      end.crash = own_crash;
      return end;
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) != kEndedBySignal)
      return describe(End::Kind::kExited, WEXITSTATUS(status));
    if (WIFEXITED(status)) {
      End end = describe(End::Kind::kKilled, SIGTERM);
      end.stage = Stage::kRunning;  // it ended only since it was told to
      return end;
    }
    End end = describe(own_crash ? End::Kind::kCrashed : End::Kind::kKilled, signal);
    end.sender = sender;
    return end;
  }

  End describe(End::Kind kind, int code) const {
    End end{.kind = kind, .code = code};
    end.stage = report_.stage;
    end.activity = report_.activity.get();
    end.remedy = report_.remedy.get();
    end.frames = report_.frames;
    end.thread = report_.crashed_thread.get();
    const bool begun = end.stage == Stage::kRunning || end.stage == Stage::kEnding;
    if (begun && end.activity.empty() && opens_or_closes()) end.activity = "opening or closing its source";
    return end;
  }

  bool opens_or_closes() const {
    return std::any_of(report_.threads.begin(), report_.threads.end(),
                       [](const ChildReport::Thread& thread) { return thread.pace == Pace::kOpening; });
  }

  void resume_after(nanoseconds step) {
    suspension_ += step;
    if (suspension_ < policy_.silence) return;
    say(fmt::format("{}: capture was suspended by another process's signal for {:.1f} s; resuming it",
                    policy_.subject, seconds(suspension_)));
    suspension_ = nanoseconds(0);
    ::kill(id_, SIGCONT);
  }

  void forget_silence() {
    for (Watched& thread : watched_) thread.silence.begin_again();
  }

  std::optional<End> look_at_threads(nanoseconds step) {
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
      if (is_suspended(id_)) {  // by a debugger: a signal's suspension is told by waitpid()
        watched.silence.begin_again();
        continue;
      }
      End end = describe(End::Kind::kHung, 0);
      end.thread = thread.name.get();
      end.silent = watched.silence.passed();
      return end;
    }
    return std::nullopt;
  }

  // Nobody waits for a process that the kernel does not let go.
  void kill_at_once() const {
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

  struct Watched {
    std::uint64_t beats = 0;
    Countdown silence;
  };

  const SupervisorPolicy& policy_;
  const BlockedSignals& signals_;
  ChildReport& report_;
  pid_t id_ = -1;
  std::function<nanoseconds()> starved_;
  std::array<Watched, ChildReport::kMostThreads> watched_;
  std::optional<Clock::time_point> stop_asked_at_;
  Countdown stopping_;
  bool suspended_ = false;
  nanoseconds suspension_{0};
};

std::string doing(const End& end) {
  if (!end.activity.empty()) return " while " + end.activity;
  switch (end.stage) {
    case Stage::kOpening:
      return " while opening it";
    case Stage::kRunning:
      return fmt::format(" after {} frames", end.frames);
    case Stage::kEnding:
      return " while it ended";
    default:
      return " while it began";
  }
}

std::string what_happened(const SupervisorPolicy& policy, const End& end) {
  const auto in_thread = [&] {
    return end.thread.empty() ? std::string() : fmt::format(", in its thread \"{}\"", end.thread);
  };
  switch (end.kind) {
    case End::Kind::kHung:
      return fmt::format("{}: capture hung{}, no sign of life from its thread \"{}\" for {:.1f} s",
                         policy.subject, doing(end), end.thread, seconds(end.silent));
    case End::Kind::kWouldNotStop:
      return fmt::format("{}: capture did not stop within {:.1f} s{} and was killed", policy.subject,
                         seconds(policy.stop_within), end.activity.empty() ? "" : doing(end));
    case End::Kind::kKilled:
      return fmt::format("{}: capture was killed by {} ({}{})", policy.subject,
                         end.sender > 0 ? fmt::format("process {}", end.sender) : "another process",
                         ::strsignal(end.code),
                         end.code == SIGKILL ? "; the system does that, too, when memory runs out" : "");
    default:
      return fmt::format("{}: capture crashed ({}){}{}", policy.subject, ::strsignal(end.code), doing(end),
                         in_thread());
  }
}

// Crashes and hangs, over the lives of several children.
class History {
 public:
  explicit History(const SupervisorPolicy& policy) : policy_(policy) {}

  // Why there is no use in another child, as the end of a sentence; nothing where there is.
  std::optional<std::string> verdict(const End& end, nanoseconds lived) {
    if (lived >= policy_.healthy_after) in_a_row_ = 0;
    ++in_a_row_;
    const bool recurs = before_ && is_same(*before_, end);
    if (end.kind != End::Kind::kKilled) before_ = end;
    if (recurs && end.stage == Stage::kPreparing && !end.remedy.empty())
      return ", twice in a row; " + end.remedy;
    const bool of_recording =
        policy_.plays_recording && (end.stage == Stage::kOpening || end.stage == Stage::kRunning);
    if (recurs && of_recording && end.kind == End::Kind::kCrashed && is_of_capture(end))
      return ", for the second time at this place: the recording is damaged where its check does not see it; "
             "record it "
             "again or take another copy";
    if (recurs && of_recording && end.kind == End::Kind::kHung)
      return ", for the second time at this place; see what record info says of the file, and end other "
             "programs";
    if (in_a_row_ < policy_.most_in_a_row) return std::nullopt;
    if (end.kind == End::Kind::kKilled)
      return fmt::format(", {} times in a row; end what kills it, or make room in memory", in_a_row_);
    return fmt::format(", {} times in a row; {}", in_a_row_,
                       policy_.plays_recording ? "please report this with the recording"
                                               : "unplug the camera and start again");
  }

  milliseconds pause() const {
    milliseconds pause = policy_.first_pause;
    for (int i = 1; i < in_a_row_ && pause < policy_.longest_pause; ++i) pause *= 2;
    return std::min(pause, policy_.longest_pause);
  }

 private:
  // By the thread that plays, or by one of which nothing is known: the encoder's crashes are not the
  // recording's fault.
  static bool is_of_capture(const End& end) { return end.thread.empty() || end.thread == "capture"; }

  bool is_same(const End& a, const End& b) const {
    const std::uint64_t apart = a.frames > b.frames ? a.frames - b.frames : b.frames - a.frames;
    return a.kind == b.kind && a.stage == b.stage && a.activity == b.activity && a.thread == b.thread &&
           apart <= policy_.same_place;
  }

  const SupervisorPolicy& policy_;
  std::optional<End> before_;
  int in_a_row_ = 0;
};

}  // namespace

int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main) {
  const BlockedSignals signals(policy.passes_hangup);
  SharedReport report;
  History history(policy);
  Predecessor predecessor;
  while (true) {
    const auto begin = Clock::now();
    End end{.kind = End::Kind::kNotBegun, .code = ENOMEM};
    if (report.has_memory())
      end = Child(policy, signals, report.begin_anew(), predecessor, child_main).wait();
    switch (end.kind) {
      case End::Kind::kNotBegun:
        say(fmt::format("{}: no process for capturing: {}; end other programs", policy.subject,
                        std::strerror(end.code)));
        return 1;
      case End::Kind::kExited:
        return end.code;
      case End::Kind::kStopped:
        if (end.crash) say(what_happened(policy, end) + ", when it was asked to stop");
        return 0;
      case End::Kind::kStoppedAtOnce:
        return 128 + end.code;
      case End::Kind::kWouldNotStop:
        if (end.stage == Stage::kOpening || end.stage == Stage::kPreparing) return 0;  // nothing was lost
        say(what_happened(policy, end));
        return 1;
      default:
        break;
    }
    if (end.stage == Stage::kEnding) {  // its work was done
      say(what_happened(policy, end));
      return 1;
    }
    if (const auto verdict = history.verdict(end, Clock::now() - begin)) {
      say(what_happened(policy, end) + *verdict);
      return 1;
    }
    say(what_happened(policy, end) + "; starting it again");
    predecessor = {true, end.kind == End::Kind::kCrashed ? end.activity : std::string()};
    for (const auto until = Clock::now() + history.pause(); Clock::now() < until;) {
      const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
      if (signals.wait(std::max(left, milliseconds(1))).stop)
        return 0;  // a new child reads what SIGHUP is about by itself
    }
  }
}

}  // namespace copresence
