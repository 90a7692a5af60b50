#include "common/wire/flow_control/arrival_watch.h"

#include <gtest/gtest.h>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using Verdict = ArrivalWatch::Verdict;

const Instant kNow = Instant{} + 100s;

/// Bytes come at a constant rate; the first verdict that is not kAlive, or kAlive once the message is complete.
struct Outcome {
  Verdict verdict;
  Duration after;
};
Outcome receive(std::size_t message_bytes, double bytes_per_second, Duration between = 100ms) {
  ArrivalWatch watch;
  watch.resume(kNow);
  Instant now = kNow;
  for (double came = 0; came < static_cast<double>(message_bytes); now += between) {
    came += bytes_per_second * std::chrono::duration<double>(between).count();
    watch.bytes_came(now);
    watch.message_has(message_bytes);
    if (watch.at(now) != Verdict::kAlive) return {watch.at(now), now - kNow};
  }
  watch.message_is_complete();
  return {watch.at(now), now - kNow};
}

TEST(ArrivalWatch, CallsAConnectionSilentAfterFiveSecondsWithoutAByte) {
  ArrivalWatch watch;
  watch.resume(kNow);
  EXPECT_EQ(watch.at(kNow + 5s), Verdict::kAlive);
  EXPECT_EQ(watch.at(kNow + 5001ms), Verdict::kSilent);
  watch.bytes_came(kNow + 4s);
  watch.message_is_complete();
  EXPECT_EQ(watch.at(kNow + 9s), Verdict::kAlive);
}

TEST(ArrivalWatch, WaitsForAKeyframeOverASlowPath) {
  for (const double kilobits_per_second : {1000.0, 100.0, 50.0, 35.0}) {
    EXPECT_EQ(receive(70'000, kilobits_per_second * 125).verdict, Verdict::kAlive) << kilobits_per_second;
  }
}

TEST(ArrivalWatch, EndsWithBytesThatComeOneByOne) {
  const Outcome small = receive(24, 0.5, 2s);
  EXPECT_EQ(small.verdict, Verdict::kTooSlow);
  EXPECT_LE(small.after, 8s);
  const Outcome large = receive(8 << 20, 10, 1s);
  EXPECT_EQ(large.verdict, Verdict::kTooSlow);
  EXPECT_LE(large.after, 62s);
}

TEST(ArrivalWatch, DoesNotCountPauses) {
  ArrivalWatch watch;
  watch.resume(kNow);
  watch.bytes_came(kNow);
  watch.message_has(8);
  watch.pause(kNow + 1s);
  watch.resume(kNow + 1h);
  EXPECT_EQ(watch.at(kNow + 1h), Verdict::kAlive);
  watch.bytes_came(kNow + 1h + 3s);
  EXPECT_EQ(watch.at(kNow + 1h + 3s), Verdict::kAlive);
  EXPECT_EQ(watch.at(kNow + 1h + 4500ms), Verdict::kTooSlow) << "five seconds of reading";
}

}  // namespace
}  // namespace copresence::wire
