#include "common/flow/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace copresence::flow {
namespace {

TEST(BoundedQueue, GivesBackWhatWasPutInInOrder) {
  BoundedQueue<int> queue(3);
  EXPECT_TRUE(queue.put(1) && queue.put(2) && queue.put(3));
  for (int expected : {1, 2, 3}) EXPECT_EQ(queue.take(), expected);
}

TEST(BoundedQueue, RefusesWhatDoesNotFitAndKeepsTheRest) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  EXPECT_TRUE(queue.has_room());
  EXPECT_TRUE(queue.put(std::make_unique<int>(1)));
  EXPECT_FALSE(queue.has_room());
  EXPECT_FALSE(queue.put(std::make_unique<int>(2)));
  EXPECT_EQ(**queue.take(), 1);
  EXPECT_TRUE(queue.has_room());
}

TEST(BoundedQueue, IsEmptiedAfterItsEnd) {
  BoundedQueue<int> queue(2);
  EXPECT_TRUE(queue.put(1));
  queue.close();
  EXPECT_FALSE(queue.put(2));
  EXPECT_EQ(queue.take(), 1);
  EXPECT_EQ(queue.take(), std::nullopt);
}

TEST(BoundedQueue, LosesNothingOfAProducerThatWaits) {
  BoundedQueue<int> queue(2);
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

TEST(BoundedQueue, AWaitingProducerObeysItsStopToken) {
  BoundedQueue<int> queue(1);
  EXPECT_TRUE(queue.put(1));
  std::stop_source stop;
  std::jthread producer(
      [&] { EXPECT_FALSE(queue.wait_for_room(stop.get_token(), std::chrono::seconds(60))); });
  stop.request_stop();
}

}  // namespace
}  // namespace copresence::flow
