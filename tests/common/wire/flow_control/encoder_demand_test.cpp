#include "common/wire/flow_control/encoder_demand.h"

#include <gtest/gtest.h>

#include <vector>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 33ms;
const Instant kNow = Instant{} + 100s;

ClientWindow joining() {
  return ClientWindow(kPeriod);
}

ClientWindow in_sync() {
  ClientWindow window(kPeriod);
  window.sent(1, 1000, kNow - 1s);
  window.acknowledge(1, kNow - 1s + 1ms);
  return window;
}

ClientWindow fallen_behind() {
  ClientWindow window = in_sync();
  window.skip(1);
  return window;
}

void update(EncoderDemand& demand, const std::vector<ClientWindow>& windows) {
  EncoderDemand::Clients clients;
  for (const ClientWindow& window : windows) clients.add(window);
  demand.update(clients);
}

TEST(EncoderDemand, RestsWithoutClients) {
  EncoderDemand demand(kPeriod);
  EXPECT_FALSE(demand.wants_frame(kNow));
  EXPECT_FALSE(demand.take_keyframe_request(kNow));
  demand.request_keyframe();
  EXPECT_FALSE(demand.wants_frame(kNow)) << "nobody would get it";
}

TEST(EncoderDemand, BeginsWithAKeyframeAndAsksForOneOnce) {
  EncoderDemand demand(kPeriod);
  update(demand, {joining()});
  EXPECT_TRUE(demand.wants_frame(kNow));
  EXPECT_TRUE(demand.take_keyframe_request(kNow));
  EXPECT_FALSE(demand.take_keyframe_request(kNow)) << "it is promised";
  EXPECT_TRUE(demand.wants_frame(kNow)) << "until it came";
  demand.sent(true, 1000, kNow);
  EXPECT_FALSE(demand.wants_frame(kNow));
}

TEST(EncoderDemand, WantsFramesWithoutKeyframesForClientsInSync) {
  EncoderDemand demand(kPeriod);
  update(demand, {in_sync()});
  EXPECT_TRUE(demand.wants_frame(kNow));
  EXPECT_FALSE(demand.take_keyframe_request(kNow));
}

TEST(EncoderDemand, AsksForAtMostOneKeyframeASecondWhoeverWantsOne) {
  EncoderDemand demand(kPeriod);
  int taken = 0;
  for (Instant now = kNow; now < kNow + 10s; now += kPeriod) {
    update(demand, {in_sync(), joining(), fallen_behind()});
    demand.request_keyframe();
    const bool keyframe = demand.take_keyframe_request(now);
    taken += keyframe;
    demand.sent(keyframe, keyframe ? 2000 : 1000, now);
  }
  EXPECT_EQ(taken, 10);
}

/// Keyframes in a hundred seconds of a stream whose keyframes have `keyframe` times the bytes of other frames.
int keyframes(const std::vector<ClientWindow>& windows, double keyframe, bool requested) {
  EncoderDemand demand(kPeriod);
  int taken = 0;
  for (Instant now = kNow; now < kNow + 100s; now += kPeriod) {
    update(demand, windows);
    if (requested) demand.request_keyframe();
    const bool is_keyframe = demand.take_keyframe_request(now);
    taken += is_keyframe;
    demand.sent(is_keyframe, static_cast<std::size_t>(is_keyframe ? 10000 * keyframe : 10000), now);
  }
  return taken;
}

TEST(EncoderDemand, LetsSlowClientsShareKeyframesThatCostTheOthersLittle) {
  EXPECT_NEAR(keyframes({in_sync(), fallen_behind()}, 2, false), 98, 3) << "one a second";
  EXPECT_NEAR(keyframes({in_sync(), fallen_behind()}, 4, false), 50, 3) << "3 extra frames of 60";
  EXPECT_NEAR(keyframes({in_sync(), fallen_behind()}, 100, false), 33, 2) << "but every three seconds";
}

TEST(EncoderDemand, LetsNobodyBuyKeyframesByAskingForThem) {
  EXPECT_NEAR(keyframes({in_sync()}, 4, true), 50, 3);
}

TEST(EncoderDemand, GivesSlowClientsAKeyframeASecondWhereNobodyPays) {
  EXPECT_NEAR(keyframes({fallen_behind(), fallen_behind()}, 4, false), 100, 4);
}

TEST(EncoderDemand, LetsNoClientThatJoinsWaitForTheSlowOnes) {
  EncoderDemand demand(kPeriod);
  update(demand, {in_sync(), fallen_behind()});
  demand.sent(false, 1000, kNow);
  ASSERT_TRUE(demand.take_keyframe_request(kNow));
  demand.sent(true, 10000, kNow);
  EXPECT_FALSE(demand.take_keyframe_request(kNow + 2s)) << "for a slow one";
  update(demand, {in_sync(), fallen_behind(), joining()});
  EXPECT_FALSE(demand.take_keyframe_request(kNow + 999ms));
  EXPECT_TRUE(demand.take_keyframe_request(kNow + 1s));
}

TEST(EncoderDemand, ForgetsWishesForKeyframesThatCame) {
  EncoderDemand demand(kPeriod);
  update(demand, {in_sync()});
  demand.request_keyframe();
  ASSERT_TRUE(demand.take_keyframe_request(kNow));
  demand.sent(true, 1000, kNow);
  EXPECT_FALSE(demand.take_keyframe_request(kNow + 10s));
}

}  // namespace
}  // namespace copresence::wire
