#include "capture_server/supervisor/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <string>

namespace copresence::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::HasSubstr;
using testing::Not;

// A counter that parent and children share.
class SharedCounter {
 public:
  SharedCounter()
      : count_(new (::mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE,
                           MAP_SHARED | MAP_ANONYMOUS, -1, 0)) std::atomic<int>(0)) {}
  ~SharedCounter() { ::munmap(count_, sizeof(std::atomic<int>)); }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;
  std::atomic<int>& operator*() { return *count_; }

 private:
  std::atomic<int>* count_;
};

// Of a recording or of a camera.
SupervisorPolicy quick(bool plays_recording = true) {
  return {.subject = "x.oni",
          .plays_recording = plays_recording,
          .silence = milliseconds(300),
          .opening = milliseconds(900),
          .stop_within = milliseconds(300),
          .stop_starved = milliseconds(3000),
          .second_stop_after = milliseconds(50),
          .first_pause = milliseconds(5),
          .longest_pause = milliseconds(20),
          .healthy_after = milliseconds(10000),
          .most_in_a_row = 10,
          .starvation = [](pid_t) { return milliseconds(0); }};
}

SupervisorPolicy camera() {
  return quick(false);
}

struct Outcome {
  int code = 0;
  std::string said;
  double seconds = 0;
};

Outcome run(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main) {
  testing::internal::CaptureStderr();
  const auto begin = steady_clock::now();
  Outcome outcome;
  outcome.code = supervise(policy, child_main);
  outcome.seconds = std::chrono::duration<double>(steady_clock::now() - begin).count();
  outcome.said = testing::internal::GetCapturedStderr();
  return outcome;
}

// Sends this process a signal in a while, as `kill` would, from a process of its own.
class SignalLater {
 public:
  SignalLater(int signal, milliseconds after) {
    const pid_t target = ::getpid();
    id_ = ::fork();
    if (id_ == 0) {
      ::usleep(static_cast<useconds_t>(after.count() * 1000));
      ::kill(target, signal);
      std::_Exit(0);
    }
  }
  ~SignalLater() { ::waitpid(id_, nullptr, 0); }
  SignalLater(const SignalLater&) = delete;
  SignalLater& operator=(const SignalLater&) = delete;

 private:
  pid_t id_;
};

volatile sig_atomic_t stopped = 0;

// A child that works until asked to stop, as a server does.
int work_until_stopped(Heartbeat& heartbeat) {
  ::signal(SIGTERM, [](int) { stopped = 1; });
  heartbeat.enter(Stage::kRunning);
  while (!stopped) {
    heartbeat.main().beat();
    ::usleep(5000);
  }
  heartbeat.enter(Stage::kEnding);
  return kEndedBySignal;
}

[[noreturn]] void hang() {
  while (true) ::pause();
}

// A sanitizer would turn these into an exit.
[[maybe_unused]] const auto default_actions =
    std::array{::signal(SIGSEGV, SIG_DFL), ::signal(SIGABRT, SIG_DFL), ::signal(SIGBUS, SIG_DFL)};

[[noreturn]] void crash() {
  ::kill(::getpid(), SIGSEGV);
  std::_Exit(99);
}

// The running child of this process; waits for one.
pid_t child_of(pid_t parent) {
  const std::string path =
      "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children";
  while (true) {
    pid_t child = 0;
    if (FILE* file = std::fopen(path.c_str(), "r")) {
      const int got = std::fscanf(file, "%d", &child);
      std::fclose(file);
      if (got == 1) return child;
    }
    ::usleep(1000);
  }
}

// Runs supervise() in a process of its own, so that a test may signal it and its child.
class Supervised {
 public:
  Supervised(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    read_end_ = ends[0];
    id_ = ::fork();
    if (id_ == 0) {
      ::dup2(ends[1], STDERR_FILENO);
      std::_Exit(supervise(policy, child_main));
    }
    ::close(ends[1]);
  }
  ~Supervised() {
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
    ::close(read_end_);
  }
  Supervised(const Supervised&) = delete;
  Supervised& operator=(const Supervised&) = delete;

  pid_t id() const { return id_; }

  // Waits for its end and returns the exit code, or minus the signal's number.
  int end() {
    char bytes[512];
    ssize_t got;
    while ((got = ::read(read_end_, bytes, sizeof(bytes))) > 0)
      said_.append(bytes, static_cast<std::size_t>(got));
    int status = 0;
    ::waitpid(id_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  const std::string& said() const { return said_; }

 private:
  pid_t id_ = -1;
  int read_end_ = -1;
  std::string said_;
};

void wait_until(const std::function<bool()>& holds) {
  while (!holds()) ::usleep(1000);
}

TEST(Supervisor, PassesOnWhatTheChildReturns) {
  EXPECT_EQ(run(quick(), [](Heartbeat&) { return 0; }).code, 0);
  EXPECT_EQ(run(quick(), [](Heartbeat&) { return 2; }).code, 2);
  EXPECT_EQ(run(camera(), [](Heartbeat&) { return 1; }).code, 1);
}

// --- a crash

TEST(Supervisor, CallsARecordingDamagedOnlyWhenACrashRecursAtTheSamePlace) {
  SharedCounter children;
  const Outcome outcome = run(quick(), [&](Heartbeat& heartbeat) -> int {
    heartbeat.enter(Stage::kRunning);
    heartbeat.main().beat();
    heartbeat.captured(static_cast<std::uint64_t>(57 + 3 * (*children)++));  // reading ahead varies
    ::prctl(PR_SET_NAME, "capture");
    crash();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(*children, 2);
  EXPECT_THAT(outcome.said,
              HasSubstr("x.oni: capture crashed (Segmentation fault) after 57 frames, in its thread "
                        "\"capture\"; starting it again\n"));
  EXPECT_THAT(outcome.said,
              HasSubstr("after 60 frames, in its thread \"capture\", for the second time at this place: the "
                        "recording is damaged where its check does not see it"));
}

TEST(Supervisor, PlaysARecordingOnAfterCrashesAtDifferentPlaces) {
  SharedCounter children;
  const Outcome outcome = run(quick(), [&](Heartbeat& heartbeat) -> int {
    const int child = (*children)++;
    if (child == 4) return 7;
    heartbeat.enter(Stage::kRunning);
    heartbeat.captured(static_cast<std::uint64_t>(1000 * child));
    crash();
  });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_THAT(outcome.said, Not(HasSubstr("damaged")));
}

TEST(Supervisor, DoesNotBlameARecordingForCrashesOfAnotherThread) {
  SupervisorPolicy policy = quick();
  policy.most_in_a_row = 3;
  const Outcome outcome = run(policy, [&](Heartbeat& heartbeat) -> int {
    heartbeat.enter(Stage::kRunning);
    ::prctl(PR_SET_NAME, "encode");
    crash();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("in its thread \"encode\", 3 times in a row"));
  EXPECT_THAT(outcome.said, Not(HasSubstr("damaged")));
}

TEST(Supervisor, NamesTheFileThatCrashesItsReaderAndEndsTheSecondTime) {
  for (const bool plays_recording : {true, false}) {
    SharedCounter children;
    const Outcome outcome = run(quick(plays_recording), [&](Heartbeat& heartbeat) -> int {
      ++*children;
      const auto activity = heartbeat.doing("reading the scene file lab.toml", "mend that file");
      crash();
    });
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(*children, 2);
    EXPECT_THAT(outcome.said,
                HasSubstr("capture crashed (Segmentation fault) while reading the scene file lab.toml"));
    EXPECT_THAT(outcome.said, HasSubstr(", twice in a row; mend that file\n"));
    EXPECT_THAT(outcome.said, Not(HasSubstr("damaged")));
  }
}

TEST(Supervisor, TellsTheNextChildWhatTheLastOneDidWhenItCrashed) {
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) -> int {
    if (heartbeat.predecessor().existed)
      return heartbeat.predecessor().crashed_while == "reading it again" ? 7 : 8;
    heartbeat.enter(Stage::kRunning);
    const auto activity = heartbeat.doing("reading it again", "mend that file");
    crash();
  });
  EXPECT_EQ(outcome.code, 7);
}

TEST(Supervisor, NamesTheStageOfACrashOutsideAnyActivity) {
  SharedCounter children;
  const Outcome outcome = run(camera(), [&](Heartbeat& heartbeat) -> int {
    const int child = (*children)++;
    if (child == 2) return 0;
    { const auto activity = heartbeat.doing("reading a file", "mend it"); }
    heartbeat.enter(child == 0 ? Stage::kOpening : Stage::kPreparing);
    std::abort();
  });
  EXPECT_THAT(outcome.said, HasSubstr("capture crashed (Aborted) while opening it"));
  EXPECT_THAT(outcome.said, HasSubstr("capture crashed (Aborted) while it began"));
}

TEST(Supervisor, EndsWhenAChildCrashesAfterItsWork) {
  SharedCounter children;
  const Outcome outcome = run(quick(), [&](Heartbeat& heartbeat) -> int {
    ++*children;
    heartbeat.enter(Stage::kEnding);
    heartbeat.main().beat();
    crash();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(*children, 1);
  EXPECT_THAT(outcome.said, HasSubstr("while it ended"));
}

TEST(Supervisor, GivesUpOnACameraThatCrashesEveryChildAtOnce) {
  SharedCounter children;
  SupervisorPolicy policy = camera();
  policy.most_in_a_row = 3;
  const Outcome outcome = run(policy, [&](Heartbeat&) -> int {
    ++*children;
    crash();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(*children, 3);
  EXPECT_THAT(outcome.said, HasSubstr("3 times in a row; unplug the camera"));
}

// --- somebody else's signals

class KilledFromOutside : public testing::TestWithParam<int> {};

TEST_P(KilledFromOutside, IsReplacedAndNeverCalledDamaged) {
  SharedCounter children;
  for (const bool plays_recording : {true, false}) {
    *children = 0;
    Supervised server(quick(plays_recording), [&](Heartbeat& heartbeat) {
      if (++*children == 4) return 7;
      return work_until_stopped(heartbeat);
    });
    for (int round = 1; round <= 3; ++round) {
      wait_until([&] { return *children == round; });
      ::usleep(20'000);  // until it handles SIGTERM, mostly: either way it is replaced
      ::kill(child_of(server.id()), GetParam());
    }
    EXPECT_EQ(server.end(), 7) << server.said();
    EXPECT_THAT(server.said(), HasSubstr("x.oni: capture was killed by "));
    EXPECT_THAT(server.said(), HasSubstr(::strsignal(GetParam())));
    EXPECT_THAT(server.said(), Not(HasSubstr("damaged")));
  }
}

INSTANTIATE_TEST_SUITE_P(Supervisor, KilledFromOutside,
                         testing::Values(SIGKILL, SIGTERM, SIGSEGV, SIGABRT, SIGHUP));

TEST(Supervisor, NamesTheProcessThatSentAFatalSignal) {
  SharedCounter children;
  Supervised server(
      quick(), [&](Heartbeat& heartbeat) { return ++*children == 2 ? 7 : work_until_stopped(heartbeat); });
  wait_until([&] { return *children == 1; });
  ::kill(child_of(server.id()), SIGSEGV);
  EXPECT_EQ(server.end(), 7);
  EXPECT_THAT(server.said(), HasSubstr("killed by process " + std::to_string(::getpid()) +
                                       " (Segmentation fault); starting it again"));
}

TEST(Supervisor, GivesUpOnAChildThatIsKilledAgainAndAgainWithTheTrueReason) {
  SupervisorPolicy policy = quick();
  policy.most_in_a_row = 3;
  const Outcome outcome = run(policy, [](Heartbeat&) -> int {
    ::kill(::getpid(), SIGKILL);  // as the system does when memory runs out
    return 0;
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("when memory runs out), 3 times in a row; end what kills it"));
}

TEST(Supervisor, ResumesAChildThatWasSuspended) {
  SharedCounter beats;
  Supervised server(quick(), [&](Heartbeat& heartbeat) {
    heartbeat.enter(Stage::kRunning);
    for (*beats = 0; *beats < 100; ++*beats) {
      heartbeat.main().beat();
      ::usleep(5000);
    }
    return 7;
  });
  wait_until([&] { return *beats > 3; });
  ::kill(child_of(server.id()), SIGSTOP);
  EXPECT_EQ(server.end(), 7) << server.said();
  EXPECT_THAT(server.said(),
              HasSubstr("x.oni: capture was suspended by another process's signal for 0.3 s; resuming it\n"));
}

TEST(Supervisor, LeavesAChildAloneThatSomebodyElseResumes) {
  SharedCounter beats;
  SupervisorPolicy policy = quick();
  policy.silence = milliseconds(5000);
  Supervised server(policy, [&](Heartbeat& heartbeat) {
    for (*beats = 0; *beats < 60; ++*beats) {
      heartbeat.main().beat();
      ::usleep(5000);
    }
    return 7;
  });
  wait_until([&] { return *beats > 3; });
  const pid_t child = child_of(server.id());
  ::kill(child, SIGSTOP);
  ::usleep(200'000);
  ::kill(child, SIGCONT);
  EXPECT_EQ(server.end(), 7);
  EXPECT_EQ(server.said(), "");
}

TEST(Supervisor, DoesNotCountTimeInWhichItWasSuspendedItself) {
  SharedCounter beats;
  Supervised server(quick(), [&](Heartbeat& heartbeat) {
    for (*beats = 0; *beats < 60; ++*beats) {
      heartbeat.main().beat();
      ::usleep(5000);
    }
    return 7;
  });
  wait_until([&] { return *beats > 3; });
  const pid_t child = child_of(server.id());
  ::kill(server.id(), SIGSTOP);
  ::kill(child, SIGSTOP);
  ::usleep(800'000);
  ::kill(server.id(), SIGCONT);  // the parent looks first
  ::usleep(50'000);
  ::kill(child, SIGCONT);
  EXPECT_EQ(server.end(), 7) << server.said();
}

// --- a hang

TEST(Supervisor, ReplacesAChildOneOfWhoseThreadsHangs) {
  for (const bool plays_recording : {true, false}) {
    SharedCounter children;
    const Outcome outcome = run(quick(plays_recording), [&](Heartbeat& heartbeat) -> int {
      if ((*children)++ == 1) return 7;
      heartbeat.enter(Stage::kRunning);
      heartbeat.main().rest();
      Pulse capture = heartbeat.pulse("capture"), encode = heartbeat.pulse("encode");
      encode.beat();  // once
      while (true) {
        capture.beat();
        ::usleep(5000);
      }
    });
    EXPECT_EQ(outcome.code, 7);
    EXPECT_THAT(outcome.said, HasSubstr("x.oni: capture hung after 0 frames, no sign of life from its thread "
                                        "\"encode\" for 0.3 s; starting"));
  }
}

TEST(Supervisor, EndsARecordingThatHangsTwiceAtTheSamePlaceWithoutCallingItDamaged) {
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) -> int {
    heartbeat.enter(Stage::kRunning);
    heartbeat.main().beat();
    heartbeat.captured(57);
    hang();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("for the second time at this place; see what record info says"));
  EXPECT_THAT(outcome.said, Not(HasSubstr("damaged")));
}

TEST(Supervisor, LeavesAChildAloneThatGivesHeartbeatsOrRests) {
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) {
    Pulse wire = heartbeat.pulse("wire");
    for (int i = 0; i < 60; ++i) {
      heartbeat.main().beat();
      i % 2 ? wire.beat() : wire.rest();
      ::usleep(10000);
    }
    wire.rest();
    heartbeat.main().rest();
    ::usleep(600'000);
    return 7;
  });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(outcome.said, "");
}

TEST(Supervisor, GivesOpeningACameraMoreTimeAtTheBeginningAndLater) {
  const Outcome outcome = run(camera(), [](Heartbeat& heartbeat) {
    ::usleep(600'000);  // twice what working may be silent
    heartbeat.main().beat();
    Pulse capture = heartbeat.pulse("capture");
    heartbeat.main().rest();
    capture.open();
    ::usleep(600'000);
    return 7;
  });
  EXPECT_EQ(outcome.code, 7) << outcome.said;
  const Outcome longer = run(quick(), [](Heartbeat& heartbeat) -> int {
    if (heartbeat.predecessor().existed) return 7;
    hang();
  });
  EXPECT_EQ(longer.code, 7);
  EXPECT_THAT(longer.said, HasSubstr("from its thread \"main\" for 0.9 s"));
}

TEST(Supervisor, AddsTheTimeInWhichTheChildGotNoCore) {
  SupervisorPolicy policy = quick();
  int looks = 0;
  policy.starvation = [&](pid_t) { return milliseconds(400) * ++looks; };
  const Outcome outcome = run(policy, [](Heartbeat& heartbeat) {
    heartbeat.main().beat();
    ::usleep(900'000);  // of at most 6 times 300 ms
    return 7;
  });
  EXPECT_EQ(outcome.code, 7) << outcome.said;
  const Outcome at_most = run(policy, [](Heartbeat& heartbeat) -> int {
    if (heartbeat.predecessor().existed) return 7;
    heartbeat.main().beat();
    hang();
  });
  EXPECT_THAT(at_most.said, HasSubstr("for 1.8 s"));
}

// --- a stop

TEST(Supervisor, StopsTheChildWhenAskedToStop) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const SignalLater later(signal, milliseconds(50));
    const Outcome outcome = run(camera(), work_until_stopped);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.said, "");
  }
}

TEST(Supervisor, CountsAStopBeforeTheChildCouldListenAsOne) {
  const SignalLater later(SIGTERM, milliseconds(50));
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) {
    while (true) {
      heartbeat.main().beat();
      ::usleep(5000);
    }
    return 0;
  });
  EXPECT_EQ(outcome.code, 0);
}

TEST(Supervisor, StopsWhateverKillsTheChildOnItsWay) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGKILL, SIGINT, SIGHUP, SIGBUS}) {
    SharedCounter children;
    const SignalLater later(SIGTERM, milliseconds(50));
    static int dies_by = 0;
    dies_by = signal;
    const Outcome outcome = run(camera(), [&](Heartbeat& heartbeat) -> int {
      ++*children;
      ::signal(SIGTERM, [](int) {
        ::signal(dies_by, SIG_DFL);
        ::kill(::getpid(), dies_by);
      });
      heartbeat.enter(Stage::kRunning);
      while (true) {
        heartbeat.main().beat();
        ::usleep(5000);
      }
    });
    EXPECT_EQ(outcome.code, 0) << signal;
    EXPECT_EQ(*children, 1) << signal;
    EXPECT_THAT(outcome.said, Not(HasSubstr("starting it again")));
  }
}

TEST(Supervisor, LeavesCtrlCToTheParentFromTheChildsFirstMomentOn) {
  SharedCounter children;
  const Outcome outcome = run(camera(), [&](Heartbeat&) -> int {
    ++*children;
    ::kill(::getpid(), SIGINT);  // a terminal sends it to both
    return 7;
  });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(*children, 1);
}

int ignore_the_stop(Heartbeat& heartbeat) {
  ::signal(SIGTERM, SIG_IGN);
  heartbeat.enter(Stage::kRunning);
  while (true) {
    heartbeat.main().beat();
    ::usleep(5000);
  }
}

TEST(Supervisor, KillsAChildThatIgnoresTheStopAndSaysWhatItWasDoing) {
  const SignalLater later(SIGTERM, milliseconds(50));
  const Outcome outcome = run(camera(), [](Heartbeat& heartbeat) {
    const auto activity = heartbeat.doing("writing the last frames of a.oni", "");
    return ignore_the_stop(heartbeat);
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said,
              HasSubstr("did not stop within 0.3 s while writing the last frames of a.oni and was killed"));
}

TEST(Supervisor, GivesAStoppingChildTheTimeInWhichItGotNoCore) {
  const SignalLater later(SIGTERM, milliseconds(50));
  SupervisorPolicy policy = quick();
  int looks = 0;
  policy.starvation = [&](pid_t) { return milliseconds(100) * looks++; };
  const Outcome outcome = run(policy, [](Heartbeat& heartbeat) {
    work_until_stopped(heartbeat);
    ::usleep(900'000);  // three times the limit
    return 0;
  });
  EXPECT_EQ(outcome.code, 0) << outcome.said;
  EXPECT_EQ(outcome.said, "");
}

TEST(Supervisor, StopsAChildThatIsOpeningACameraWithoutAWord) {
  const SignalLater later(SIGTERM, milliseconds(50));
  const Outcome outcome = run(camera(), [](Heartbeat& heartbeat) -> int {
    ::signal(SIGTERM, SIG_IGN);
    heartbeat.enter(Stage::kOpening);
    hang();
  });
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.said, "");
}

TEST(Supervisor, StopsAChildThatIsSuspended) {
  SharedCounter children;
  Supervised server(quick(), [&](Heartbeat& heartbeat) {
    ++*children;
    return work_until_stopped(heartbeat);
  });
  wait_until([&] { return *children == 1; });
  ::kill(child_of(server.id()), SIGSTOP);
  ::kill(server.id(), SIGTERM);
  EXPECT_EQ(server.end(), 0) << server.said();
}

TEST(Supervisor, EndsAtOnceOnASecondCtrlCHoweverLongAStopMayTake) {
  for (const int first : {SIGINT, SIGTERM}) {
    SupervisorPolicy policy = camera();
    policy.stop_within = policy.stop_starved = std::chrono::hours(1);
    SharedCounter children;
    Supervised server(policy, [&](Heartbeat& heartbeat) {
      ++*children;
      return ignore_the_stop(heartbeat);
    });
    wait_until([&] { return *children == 1; });
    ::kill(server.id(), first);
    ::usleep(100'000);
    ::kill(server.id(), SIGTERM);  // changes nothing
    ::usleep(100'000);
    EXPECT_EQ(::waitpid(server.id(), nullptr, WNOHANG), 0);
    ::kill(server.id(), SIGINT);
    EXPECT_EQ(server.end(), 128 + SIGINT);
  }
}

TEST(Supervisor, TakesStopsOfOneMomentAsOne) {
  SharedCounter ended;
  SupervisorPolicy policy = camera();
  policy.second_stop_after = std::chrono::hours(1);
  Supervised server(policy, [&](Heartbeat& heartbeat) {
    work_until_stopped(heartbeat);
    ::usleep(100'000);
    ++*ended;
    return 0;
  });
  ::usleep(100'000);
  for (int i = 0; i < 5; ++i) {
    ::kill(server.id(), i % 2 ? SIGTERM : SIGINT);
    ::usleep(2000);
  }
  EXPECT_EQ(server.end(), 0);
  EXPECT_EQ(*ended, 1);
}

TEST(Supervisor, StopsAlsoWhileItPausesBetweenChildren) {
  SupervisorPolicy policy = camera();
  policy.first_pause = policy.longest_pause = std::chrono::hours(1);
  const SignalLater later(SIGTERM, milliseconds(100));
  EXPECT_EQ(run(policy, [](Heartbeat&) -> int { crash(); }).code, 0);
}

TEST(Supervisor, PassesAHangupOnToTheChildAndSurvivesIt) {
  SupervisorPolicy policy = quick();
  policy.passes_hangup = true;
  const SignalLater later(SIGHUP, milliseconds(50));
  const Outcome outcome = run(policy, [](Heartbeat& heartbeat) {
    sigset_t hangup;
    sigemptyset(&hangup);
    sigaddset(&hangup, SIGHUP);
    ::usleep(100'000);  // it comes before anybody listens
    heartbeat.main().beat();
    const timespec patience{0, 200'000'000};
    return ::sigtimedwait(&hangup, nullptr, &patience) == SIGHUP ? 7 : 8;
  });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(outcome.said, "");
}

TEST(Supervisor, LeavesNoChildBehindWhenItIsKilled) {
  SharedCounter child_id;
  const pid_t parent = ::fork();
  if (parent == 0) {
    std::_Exit(supervise(quick(), [&](Heartbeat& heartbeat) {
      *child_id = ::getpid();
      return work_until_stopped(heartbeat);
    }));
  }
  while (*child_id == 0) ::usleep(1000);
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  const auto give_up = steady_clock::now() + std::chrono::seconds(1);
  // A zombie whose new parent has not looked yet is gone as well.
  const auto alive = [&] {
    std::string path = "/proc/" + std::to_string(*child_id) + "/stat";
    FILE* stat = std::fopen(path.c_str(), "r");
    if (!stat) return false;
    char state = 0;
    const int got = std::fscanf(stat, "%*d (%*[^)]) %c", &state);
    std::fclose(stat);
    return got == 1 && state != 'Z' && state != 'X';
  };
  while (alive() && steady_clock::now() < give_up) ::usleep(5000);
  EXPECT_FALSE(alive());
}

}  // namespace
}  // namespace copresence::server
