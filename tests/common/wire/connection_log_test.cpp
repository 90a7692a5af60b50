#include "common/wire/connection_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::SizeIs;

const Instant kNow = Instant{} + 1000s;

TEST(ConnectionLog, HasALineForEachViewer) {
  ConnectionLog log;
  log.joined("10.0.0.1:5000", 1, kNow);
  log.left("10.0.0.1:5000", Ending::kHungUp, 35s, 0, kNow + 35s);
  log.left("10.0.0.2:5000", Ending::kNoProgress, 70s, 0, kNow + 35s);
  EXPECT_THAT(log.take(kNow + 35s),
              ElementsAre(Field(&ConnectionLog::Line::text, "viewer 10.0.0.1:5000 connected (1 now)"),
                          Field(&ConnectionLog::Line::text, "viewer 10.0.0.1:5000 left after 35 s (0 now)"),
                          Field(&ConnectionLog::Line::text,
                                "viewer 10.0.0.2:5000 left after 70 s: it acknowledged no frame (0 now)")));
  EXPECT_THAT(log.take(kNow + 35s), SizeIs(0)) << "each once";
}

TEST(ConnectionLog, SumsUpAnAttackInOneLine) {
  ConnectionLog log;
  for (int i = 0; i < 5000; ++i) log.ended_early("10.0.0.1", Ending::kNoHello, kNow);
  for (int i = 0; i < 10; ++i) log.ended_early("10.0.0.2", Ending::kMadeRoom, kNow + 5s);
  EXPECT_THAT(log.take(kNow + 5s), SizeIs(0));
  const auto lines = log.take(kNow + 10s);
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_TRUE(lines[0].is_warning);
  EXPECT_EQ(lines[0].text,
            "5010 connections in the last 10 s ended before the first frame was acknowledged: 5000 sent no "
            "hello, 10 made room for others; 5000 came from 10.0.0.1");
  EXPECT_THAT(log.take(kNow + 20s), SizeIs(0)) << "nothing happened since";
}

TEST(ConnectionLog, StaysShortWhateverHappens) {
  ConnectionLog log;
  std::size_t lines = 0;
  for (int second = 0; second < 100; ++second) {
    for (int i = 0; i < 1000; ++i) {
      const Instant now = kNow + second * 1s + i * 1ms;
      log.joined("10.0.0.1:" + std::to_string(i), 1, now);
      log.left("10.0.0.1:" + std::to_string(i), Ending::kHungUp, 1ms, 0, now);
      log.ended_early("10.0.0." + std::to_string(i), Ending::kNonsense, now);
      lines += log.take(now).size();
    }
  }
  EXPECT_LE(lines, 10 * (ConnectionLog::kLines + 2) + 2);
}

TEST(ConnectionLog, CountsWhatItDoesNotSay) {
  ConnectionLog log;
  for (std::size_t i = 0; i < ConnectionLog::kLines + 3; ++i) log.joined("10.0.0.1:1", 1, kNow);
  log.left("10.0.0.1:1", Ending::kHungUp, 1s, 0, kNow);
  EXPECT_THAT(log.take(kNow), SizeIs(ConnectionLog::kLines));
  EXPECT_THAT(log.take(kNow + 10s), ElementsAre(Field(&ConnectionLog::Line::text,
                                                      HasSubstr("3 more viewers connected and 1 left"))));
}

}  // namespace
}  // namespace copresence::wire
