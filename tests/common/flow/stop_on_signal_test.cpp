#include "common/flow/stop_on_signal.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

namespace copresence::flow {
namespace {

TEST(StopOnSignal, TurnsSigtermIntoAStopRequest) {
  StopOnSignal signals;
  EXPECT_FALSE(signals.token().stop_requested());
  kill(getpid(), SIGTERM);
  for (int i = 0; i < 200 && !signals.token().stop_requested(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(signals.token().stop_requested());
}

TEST(StopOnSignal, CallsBackOnSighupAndDoesNotStop) {
  std::atomic<int> hangups = 0;
  StopOnSignal signals([&] { ++hangups; });
  kill(getpid(), SIGHUP);
  for (int i = 0; i < 200 && hangups == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(hangups, 1);
  EXPECT_FALSE(signals.token().stop_requested());
}

}  // namespace
}  // namespace copresence::flow
