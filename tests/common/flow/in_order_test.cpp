#include "common/flow/in_order.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace copresence::flow {
namespace {

TEST(InOrder, GivesBackWhatWasPutInInOrder) {
  InOrder<int> queue(3);
  EXPECT_TRUE(queue.put(1) && queue.put(2) && queue.put(3));
  for (int expected : {1, 2, 3}) EXPECT_EQ(queue.take(), expected);
}

TEST(InOrder, RefusesWhatDoesNotFitAndKeepsTheRest) {
  InOrder<std::unique_ptr<int>> queue(1);
  EXPECT_TRUE(queue.has_room());
  EXPECT_TRUE(queue.put(std::make_unique<int>(1)));
  EXPECT_FALSE(queue.has_room());
  EXPECT_FALSE(queue.put(std::make_unique<int>(2)));
  EXPECT_EQ(**queue.take(), 1);
  EXPECT_TRUE(queue.has_room());
}

TEST(InOrder, IsEmptiedAfterItsEnd) {
  InOrder<int> queue(2);
  EXPECT_TRUE(queue.put(1));
  queue.close();
  EXPECT_FALSE(queue.put(2));
  EXPECT_EQ(queue.take(), 1);
  EXPECT_EQ(queue.take(), std::nullopt);
}

TEST(InOrder, LosesNothingOfAProducerThatWaits) {
  InOrder<int> queue(2);
  std::vector<int> taken;
  std::jthread reader([&] {
    while (const auto value = queue.take()) taken.push_back(*value);
  });
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(queue.wait_for_room({}, std::chrono::seconds(60)));
    ASSERT_TRUE(queue.put(i));
  }
  queue.close();
  reader.join();
  ASSERT_EQ(taken.size(), 1000u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(taken[static_cast<std::size_t>(i)], i);
}

TEST(InOrder, AWaitingProducerObeysItsStopToken) {
  InOrder<int> queue(1);
  EXPECT_TRUE(queue.put(1));
  std::stop_source stop;
  std::jthread producer([&] { EXPECT_FALSE(queue.wait_for_room(stop.get_token(), std::chrono::seconds(60))); });
  stop.request_stop();
}

}  // namespace
}  // namespace copresence::flow
