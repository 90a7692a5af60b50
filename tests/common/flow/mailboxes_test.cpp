#include "common/flow/mailboxes.h"

#include <gtest/gtest.h>

#include <thread>

namespace copresence::flow {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(Mailboxes, KeepsSlotsApartAndTheNewestInEach) {
  Mailboxes<int> board(2);
  EXPECT_FALSE(board.put(0, 1));
  EXPECT_TRUE(board.put(0, 2));
  EXPECT_FALSE(board.put(1, 9));
  EXPECT_EQ(board.take(0), 2);
  EXPECT_EQ(board.take(0), std::nullopt);
  EXPECT_EQ(board.take(1), 9);
}

TEST(Mailboxes, WaitReturnsOncePerBatchOfPuts) {
  Mailboxes<int> board(2);
  board.put(0, 1);
  board.put(1, 1);
  const auto start = steady_clock::now();
  board.wait({}, start + milliseconds(5000));  // both are seen
  EXPECT_LT(steady_clock::now() - start, milliseconds(2000));
  board.wait({}, steady_clock::now() + milliseconds(20));
  EXPECT_GE(steady_clock::now() - start, milliseconds(20));
}

TEST(Mailboxes, WakesAWaitingReader) {
  Mailboxes<int> board(1);
  std::jthread writer([&] { board.put(0, 5); });
  board.wait({}, steady_clock::now() + std::chrono::seconds(20));
  writer.join();
  EXPECT_EQ(board.take(0), 5);
}

TEST(Mailboxes, StopsWaitingWhenAskedTo) {
  Mailboxes<int> board(1);
  std::stop_source stop;
  stop.request_stop();
  board.wait(stop.get_token(), steady_clock::now() + std::chrono::seconds(20));
  EXPECT_EQ(board.take(0), std::nullopt);
}

}  // namespace
}  // namespace copresence::flow
