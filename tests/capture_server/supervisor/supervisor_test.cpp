#include "capture_server/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace copresence {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::HasSubstr;

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

SupervisorPolicy quick(bool restart = false) {
  return {.subject = "x.oni",
          .restart = restart,
          .silence = milliseconds(300),
          .first_silence = milliseconds(300),
          .stop_within = milliseconds(300),
          .first_pause = milliseconds(5),
          .longest_pause = milliseconds(20),
          .healthy_after = milliseconds(10000),
          .most_in_a_row = 10};
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
  while (!stopped) {
    heartbeat.beat();
    ::usleep(5000);
  }
  return 0;
}

[[noreturn]] void crash() {
  ::signal(SIGSEGV, SIG_DFL);  // whatever a sanitizer does with it
  ::kill(::getpid(), SIGSEGV);
  std::_Exit(99);
}

TEST(Supervisor, PassesOnWhatTheChildReturns) {
  EXPECT_EQ(run(quick(), [](Heartbeat&) { return 0; }).code, 0);
  EXPECT_EQ(run(quick(), [](Heartbeat&) { return 2; }).code, 2);
  EXPECT_EQ(run(quick(true), [](Heartbeat&) { return 1; }).code, 1);
}

TEST(Supervisor, EndsWithOneSentenceWhenARecordingCrashesItsChild) {
  const Outcome outcome = run(quick(), [](Heartbeat&) -> int { crash(); });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.said,
            "x.oni: capturing crashed (Segmentation fault), so it is damaged where its check does not see "
            "it; record it "
            "again\n");
}

TEST(Supervisor, EndsARecordingThatHangsItsChild) {
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) {
    heartbeat.beat();
    while (true) ::pause();
    return 0;
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("x.oni: capturing hung, no sign of life for 0.3 s"));
}

TEST(Supervisor, LeavesAChildAloneThatGivesHeartbeats) {
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) {
    for (int i = 0; i < 60; ++i) {
      heartbeat.beat();
      ::usleep(10000);
    }
    return 7;
  });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(outcome.said, "");
}

TEST(Supervisor, GivesACameraANewChild) {
  SharedCounter children;
  const Outcome outcome = run(quick(true), [&](Heartbeat&) -> int {
    const int child = (*children)++;
    if (child == 0) crash();
    if (child == 1) {
      while (true) ::pause();
    }
    return 5;
  });
  EXPECT_EQ(outcome.code, 5);
  EXPECT_EQ(*children, 3);
  EXPECT_THAT(outcome.said, HasSubstr("crashed (Segmentation fault); starting it again"));
  EXPECT_THAT(outcome.said, HasSubstr("hung"));
}

TEST(Supervisor, GivesUpOnACameraThatCrashesEveryChildAtOnce) {
  SharedCounter children;
  SupervisorPolicy policy = quick(true);
  policy.most_in_a_row = 3;
  const Outcome outcome = run(policy, [&](Heartbeat&) -> int {
    ++*children;
    crash();
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(*children, 3);
  EXPECT_THAT(outcome.said, HasSubstr("3 times in a row"));
}

TEST(Supervisor, StopsTheChildWhenAskedToStop) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const SignalLater later(signal, milliseconds(50));
    const Outcome outcome = run(quick(true), work_until_stopped);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.said, "");
    EXPECT_LT(outcome.seconds, 1);
  }
}

TEST(Supervisor, CountsAStopBeforeTheChildCouldListenAsOne) {
  const SignalLater later(SIGTERM, milliseconds(50));
  const Outcome outcome = run(quick(), [](Heartbeat& heartbeat) {
    while (true) {
      heartbeat.beat();
      ::usleep(5000);
    }
    return 0;
  });
  EXPECT_EQ(outcome.code, 0);
}

TEST(Supervisor, KillsAChildThatIgnoresTheStop) {
  const SignalLater later(SIGTERM, milliseconds(50));
  const Outcome outcome = run(quick(true), [](Heartbeat& heartbeat) {
    ::signal(SIGTERM, SIG_IGN);
    while (true) {
      heartbeat.beat();
      ::usleep(5000);
    }
    return 0;
  });
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("did not stop within 0.3 s"));
  EXPECT_LT(outcome.seconds, 1);
}

TEST(Supervisor, StopsAlsoWhileItPausesBetweenChildren) {
  SupervisorPolicy policy = quick(true);
  policy.first_pause = policy.longest_pause = milliseconds(5000);
  const SignalLater later(SIGTERM, milliseconds(100));
  const Outcome outcome = run(policy, [](Heartbeat&) -> int { crash(); });
  EXPECT_EQ(outcome.code, 0);
  EXPECT_LT(outcome.seconds, 1);
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
    heartbeat.beat();
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
}  // namespace copresence
