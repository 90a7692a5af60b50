#include "common/flow/stop_on_signal.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <csignal>
#include <fstream>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace copresence::flow {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;

bool comes_true(const std::function<bool()>& condition) {
  for (const auto end = steady_clock::now() + seconds(20); !condition();) {
    if (steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

void block_for_good() {
  while (true) pause();
}

/// A process of its own that runs `behaviour`, whose result is its exit code. wait() tells how it ended.
class OtherProcess {
 public:
  explicit OtherProcess(const std::function<int(const std::function<void()>& say_ready)>& behaviour) {
    int ends[2];
    if (pipe(ends) != 0) std::abort();
    id_ = fork();
    if (id_ == 0) {
      alarm(60);
      _exit(behaviour([&] { (void)!write(ends[1], "r", 1); }));
    }
    close(ends[1]);
    ready_ = ends[0];
  }
  ~OtherProcess() {
    kill(id_, SIGKILL);
    wait();
    close(ready_);
  }

  /// Until it calls say_ready() once more.
  bool is_ready() const {
    char one = 0;
    return read(ready_, &one, 1) == 1;
  }
  void signal(int number) const { kill(id_, number); }
  bool has_taken_every_signal() const {
    std::ifstream status("/proc/" + std::to_string(id_) + "/status");
    for (std::string word; status >> word;) {
      if (word == "ShdPnd:") return status >> word && word.find_first_not_of('0') == std::string::npos;
    }
    return true;  // it has ended
  }
  bool runs() {
    waited_ = waited_ || waitpid(id_, &status_, WNOHANG) == id_;
    return !waited_;
  }
  int wait() {
    if (!std::exchange(waited_, true)) waitpid(id_, &status_, 0);
    return status_;
  }

 private:
  pid_t id_ = -1;
  int ready_ = -1, status_ = 0;
  bool waited_ = false;
};

TEST(StopOnSignal, TurnsSigtermIntoAStopRequest) {
  StopOnSignal signals;
  EXPECT_FALSE(signals.token().stop_requested());
  kill(getpid(), SIGTERM);
  EXPECT_TRUE(comes_true([&] { return signals.token().stop_requested(); }));
}

TEST(StopOnSignal, CallsBackOnSighupAndDoesNotStop) {
  std::atomic<int> hangups = 0;
  StopOnSignal signals([&] { ++hangups; });
  kill(getpid(), SIGHUP);
  EXPECT_TRUE(comes_true([&] { return hangups == 1; }));
  EXPECT_FALSE(signals.token().stop_requested());
}

TEST(StopOnSignal, StopsWhileTheHangupCallbackBlocks) {
  std::stop_source release;
  std::atomic<bool> blocks = false;
  StopOnSignal signals([&, token = release.get_token()] {
    blocks = true;
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait(lock, token, [] { return false; });
  });
  kill(getpid(), SIGHUP);
  EXPECT_TRUE(comes_true([&] { return blocks.load(); }));
  kill(getpid(), SIGTERM);
  EXPECT_TRUE(comes_true([&] { return signals.token().stop_requested(); }));
  release.request_stop();
}

TEST(StopOnSignal, TheFirstInterruptStopsInOrder) {
  OtherProcess process([](const auto& say_ready) {
    StopOnSignal signals;
    say_ready();
    return comes_true([&] { return signals.token().stop_requested(); }) ? 7 : 1;
  });
  ASSERT_TRUE(process.is_ready());
  process.signal(SIGINT);
  const int status = process.wait();
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST(StopOnSignal, TheSecondInterruptEndsAProcessWhoseThreadsHang) {
  OtherProcess process([](const auto& say_ready) {
    StopOnSignal signals;
    const std::stop_callback first(signals.token(), say_ready);
    say_ready();
    block_for_good();
    return 0;
  });
  ASSERT_TRUE(process.is_ready());
  process.signal(SIGINT);
  ASSERT_TRUE(process.is_ready()) << "the first one requested a stop";
  process.signal(SIGINT);
  const int status = process.wait();
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGINT);
}

TEST(StopOnSignal, TheSecondInterruptEndsAProcessThatHangsInAStopCallback) {
  OtherProcess process([](const auto& say_ready) {
    std::signal(SIGINT, SIG_IGN);  // as a shell starts programs in the background
    StopOnSignal signals;
    const std::stop_callback hangs(signals.token(), [&] {
      say_ready();
      block_for_good();
    });
    say_ready();
    block_for_good();
    return 0;
  });
  ASSERT_TRUE(process.is_ready());
  process.signal(SIGINT);
  ASSERT_TRUE(process.is_ready());
  process.signal(SIGINT);
  EXPECT_TRUE(WIFSIGNALED(process.wait()));
}

TEST(StopOnSignal, NeitherTwoTerminationsNorOneOfEachEndAProcessEarly) {
  // A terminal's Ctrl-C reaches parent and child, and the parent hands it on as SIGTERM: in whichever order they come.
  for (const auto& signals_sent :
       {std::vector{SIGTERM, SIGTERM, SIGINT, SIGTERM}, {SIGINT, SIGTERM, SIGTERM}}) {
    OtherProcess process([](const auto& say_ready) {
      StopOnSignal signals;
      say_ready();
      block_for_good();
      return 0;
    });
    ASSERT_TRUE(process.is_ready());
    for (const int signal : signals_sent) {
      process.signal(signal);
      ASSERT_TRUE(comes_true([&] { return process.has_taken_every_signal(); }));
      ASSERT_TRUE(process.runs()) << signal;
    }
  }
}

}  // namespace
}  // namespace copresence::flow
