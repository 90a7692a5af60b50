#include "common/flow/mailbox.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace copresence::flow {
namespace {

TEST(Mailbox, HandsOverTheNewestAndCountsWhatItReplaced) {
  Mailbox<int> mailbox;
  mailbox.put(1);
  mailbox.put(2);
  mailbox.put(3);
  EXPECT_EQ(mailbox.try_take(), 3);
  EXPECT_EQ(mailbox.try_take(), std::nullopt);
  EXPECT_EQ(mailbox.overwritten(), 2u);
}

TEST(Mailbox, WakesAWaitingTakerWithTheValue) {
  Mailbox<int> mailbox;
  std::optional<int> taken;
  std::jthread taker([&](std::stop_token stop) { taken = mailbox.take(stop); });
  mailbox.put(7);
  taker.join();
  EXPECT_EQ(taken, 7);
}

TEST(Mailbox, LetsAWaitingTakerGoWhenAskedToStop) {
  Mailbox<int> mailbox;
  std::optional<int> taken = 1;
  std::jthread taker([&](std::stop_token stop) { taken = mailbox.take(stop); });
  taker.request_stop();
  taker.join();
  EXPECT_EQ(taken, std::nullopt);
}

TEST(Mailbox, HandsOverTheLastValueAfterItWasClosedAndThenNothing) {
  Mailbox<int> mailbox;
  mailbox.put(5);
  mailbox.close();
  EXPECT_EQ(mailbox.take({}), 5);
  EXPECT_EQ(mailbox.take({}), std::nullopt);
}

TEST(Mailbox, LosesNothingUncountedBetweenTwoThreads) {
  Mailbox<int> mailbox;
  constexpr int kValues = 20000;
  int taken = 0, last = 0;
  std::jthread taker([&](std::stop_token stop) {
    while (auto value = mailbox.take(stop)) {
      EXPECT_GT(*value, last);
      last = *value;
      ++taken;
    }
  });
  for (int i = 1; i <= kValues; ++i) mailbox.put(i);
  mailbox.close();
  taker.join();
  EXPECT_EQ(taken + static_cast<int>(mailbox.overwritten()), kValues);
  EXPECT_EQ(last, kValues);
}

TEST(Mailbox, LosesNothingOfAProducerThatWaits) {
  Mailbox<int> mailbox;
  constexpr int kValues = 2000;
  int taken = 0;
  std::jthread taker([&](std::stop_token stop) {
    while (mailbox.take(stop)) ++taken;
  });
  for (int i = 1; i <= kValues; ++i) {
    mailbox.wait_until_taken({});
    mailbox.put(i);
  }
  mailbox.close();
  taker.join();
  EXPECT_EQ(taken, kValues);
  EXPECT_EQ(mailbox.overwritten(), 0u);
}

}  // namespace
}  // namespace copresence::flow
