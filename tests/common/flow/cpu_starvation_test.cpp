#include "common/flow/cpu_starvation.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>
#include <vector>

namespace copresence::flow {
namespace {

TEST(CpuStarvation, GrowsWhereThreadsOutnumberCores) {
  if (!std::filesystem::exists("/proc/self/schedstat")) GTEST_SKIP() << "this kernel does not count it";
  CpuStarvation starvation(::getpid());
  starvation.look();
  std::chrono::nanoseconds grown{0};
  {
    std::vector<std::jthread> busy;
    for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency() + 2; ++i)
      busy.emplace_back([](std::stop_token stop) {
        while (!stop.stop_requested()) {
        }
      });
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    grown = starvation.look();
  }
  EXPECT_GT(grown, std::chrono::milliseconds(50));
}

using std::chrono::milliseconds;
constexpr StallTimeout kStallTimeout{milliseconds(1000), milliseconds(4000)};

TEST(StallTimeout, IsOverAfterTheUsualTimeWhereCoresWereToBeHad) {
  EXPECT_FALSE(kStallTimeout.is_over(milliseconds(1000), milliseconds(0)));
  EXPECT_TRUE(kStallTimeout.is_over(milliseconds(1001), milliseconds(0)));
}

TEST(StallTimeout, LastsLongerByWhatALatePlayerLost) {
  EXPECT_FALSE(kStallTimeout.is_over(milliseconds(2500), milliseconds(1600)));
  EXPECT_TRUE(kStallTimeout.is_over(milliseconds(2500), milliseconds(1400)));
}

TEST(StallTimeout, IsNeverEndless) {
  EXPECT_FALSE(kStallTimeout.is_over(milliseconds(4000), std::chrono::hours(1)));
  EXPECT_TRUE(kStallTimeout.is_over(milliseconds(4001), std::chrono::hours(1)));
}

}  // namespace
}  // namespace copresence::flow
