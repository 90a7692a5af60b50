#include "capture_server/drivers/simulated/shared_projectors.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/process.h"

namespace copresence::drivers {
namespace {

TEST(SharedProjectors, AreSeenByEveryoneWhoOpensTheFile) {
  testing::TemporaryFolder folder;
  auto one = SharedProjectors::open(folder / "air"), other = SharedProjectors::open(folder / "air");
  ASSERT_TRUE(one && other);
  EXPECT_TRUE(other->on().none());
  one->set(3, true);
  EXPECT_TRUE(other->on()[3]);
  EXPECT_EQ(other->on().count(), 1u);
  const auto late = SharedProjectors::open(folder / "air");
  EXPECT_TRUE(late->on()[3]);
  other->set(3, false);
  EXPECT_TRUE(one->on().none());
}

TEST(SharedProjectors, GoDarkWithTheProcessThatIsKilled) {
  testing::TemporaryFolder folder;
  const auto air = SharedProjectors::open(folder / "air");
  ASSERT_TRUE(air);
  const pid_t process = ::fork();
  if (process == 0) {
    SharedProjectors::open(folder / "air")->set(2, true);
    while (true) ::pause();
  }
  while (air->on().none()) ::usleep(1000);
  EXPECT_TRUE(air->on()[2]);
  ::kill(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
  EXPECT_TRUE(air->on().none());
}

TEST(SharedProjectors, NameTheFileThatCannotBe) {
  const auto air = SharedProjectors::open("/nonexistent/air");
  ASSERT_FALSE(air);
  EXPECT_NE(air.error().what.find("/nonexistent/air"), std::string::npos);
}

}  // namespace
}  // namespace copresence::drivers
