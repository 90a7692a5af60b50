// What the wire does only after seconds: too slow for a unit test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/wire/flow_control/client_window.h"
#include "tests/common/wire/raw_peer.h"
#include "tests/common/wire/served.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

TEST(Patience, EndsWithWhoeverDoesNotSayHello) {
  Served served;
  const auto before = std::chrono::steady_clock::now();
  RawPeer half(served.address());
  const Bytes hello = encode(Hello{});
  half.say(Bytes(hello.begin(), hello.begin() + 10));
  half.hear_out();
  EXPECT_GT(std::chrono::steady_clock::now() - before, 1s);
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
}

TEST(Patience, EndsWithAServerThatFellSilent) {
  asio::io_context io;
  asio::ip::tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
  std::jthread frozen([&] {
    RawPeer peer(acceptor);
    peer.hear();
    peer.say(encode(sample_welcome()));
    peer.hear_out();
  });
  const std::string address = "127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
  auto client = FrameClient::connect(address, 2s, {});
  ASSERT_TRUE(client);
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kTimeout);
}

TEST(Patience, SendsAKeyframeToWhoeverAsksOncePerSecond) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  ASSERT_NE(served.capture_when_wanted(), 0u);
  const auto before = std::chrono::steady_clock::now();
  EXPECT_TRUE(client->receive({})->frame.keyframe);
  for (int i = 0; i < 3; ++i) {
    client->request_keyframe();
    ASSERT_NE(served.capture_when_wanted(), 0u);
    const bool keyframe = client->receive({})->frame.keyframe;
    EXPECT_TRUE(!keyframe || std::chrono::steady_clock::now() - before > 900ms) << "there was one just now";
  }
  EXPECT_TRUE(eventually([&] { return served.server().take_keyframe_request(); }));
  EXPECT_FALSE(served.server().take_keyframe_request());
}

TEST(Patience, LetsAFastClientHaveEveryFrameWhateverASlowOneDoes) {
  Served served;
  auto fast = served.client();
  auto slow = served.client();
  ASSERT_TRUE(fast && slow);
  ASSERT_TRUE(eventually([&] { return served.server().counters().clients == 2; }));
  for (std::uint64_t sequence = 1; sequence <= 200; ++sequence) {
    ASSERT_EQ(served.capture_when_wanted(30000), sequence);
    const auto received = fast->receive({});
    ASSERT_TRUE(received);
    EXPECT_EQ(received->frame.sequence, sequence);
    EXPECT_EQ(received->counters.window_full, 0u);
  }
  EXPECT_LE(served.frames_held(), static_cast<long>(ClientWindow::kFramesOnUnknownPath) + 1);

  // The slow one wakes up: what was on its way, then nothing until a keyframe; and it can say what it missed.
  std::uint64_t last = 0;
  for (;;) {
    auto received = slow->receive({});
    ASSERT_TRUE(received);
    if (received->frame.keyframe && last > 0) {
      EXPECT_EQ(received->frame.sequence - last - 1, received->counters.window_full);
      break;
    }
    EXPECT_EQ(received->frame.sequence, ++last);
    if (last < ClientWindow::kFramesOnUnknownPath) continue;
    ASSERT_TRUE(eventually([&] { return served.server().take_keyframe_request(); }));
    auto keyframe = std::make_shared<EncodedFrame>();
    keyframe->keyframe = true;
    keyframe->sequence = 201;
    keyframe->depth = {1};
    served.server().send(keyframe, {201, 0, 0});
  }
  EXPECT_EQ(last, ClientWindow::kFramesOnUnknownPath);
}

TEST(Patience, HoldsNothingBackOverThousandsOfFrames) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  for (std::uint64_t sequence = 1; sequence <= 5000; ++sequence) {
    ASSERT_EQ(served.capture_when_wanted(20000), sequence);
    ASSERT_TRUE(client->receive({}));
    ASSERT_LE(served.frames_held(), 2);
  }
}

}  // namespace
}  // namespace copresence::wire
