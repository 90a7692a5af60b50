// Server and clients over 127.0.0.1, in one process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/wire/flow_control/admission.h"
#include "tests/common/wire/raw_peer.h"
#include "tests/common/wire/served.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Loopback, CarriesAFrameAsItIs) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client) << client.error().what;
  EXPECT_EQ(client->description(), sample_description());
  EXPECT_EQ(client->clock(), ClockOffset{}) << "both read this machine's clock";
  ASSERT_EQ(served.capture_when_wanted(50000), 1u);
  const auto received = client->receive({});
  ASSERT_TRUE(received) << received.error().what;
  EXPECT_TRUE(received->frame.keyframe);
  EXPECT_EQ(received->frame.sequence, 1u);
  EXPECT_EQ(received->frame.depth, std::vector<std::uint8_t>(50000, 1));
  EXPECT_EQ(received->frame.color, std::vector<std::uint8_t>(25000, 0x55));
  EXPECT_EQ(received->counters, (FrameCounters{.captured = 1}));
  EXPECT_LE(received->sent_at, received->received_at);
  EXPECT_EQ(client->bytes_received(), 299 + 104 + 75000u);
}

TEST(Loopback, CarriesFramesWithoutColourAndOfEverySize) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  for (const std::size_t size : {1u, 2u, 65536u, 1000000u, 5000000u}) {
    ASSERT_NE(served.capture_when_wanted(size), 0u);
    const auto received = client->receive({});
    ASSERT_TRUE(received) << received.error().what;
    EXPECT_EQ(received->frame.depth.size(), size);
    EXPECT_EQ(received->frame.color.size(), size / 2);
  }
}

TEST(Loopback, SendsWhatKeepsTheCameraFromSendingAndThatItIsBack) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  std::vector<std::string> heard, heard_late;
  client->on_camera_status([&](const std::string& status) { heard.push_back(status); });
  served.server().set_camera_status("unplugged");
  auto late = served.client();
  ASSERT_TRUE(late);
  late->on_camera_status([&](const std::string& status) { heard_late.push_back(status); });
  served.server().set_camera_status("");
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}));
  EXPECT_TRUE(late->receive({}));
  EXPECT_EQ(heard, (std::vector<std::string>{"unplugged", ""}));
  EXPECT_EQ(heard_late, heard);
}

TEST(Loopback, TellsWhyAStreamEnds) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  ASSERT_NE(served.capture_when_wanted(), 0u);
  served.server().end("the recording is over");
  EXPECT_TRUE(client->receive({})) << "a frame sent before still arrives";
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(received.error().what, "the recording is over");
}

TEST(Loopback, EndsInTimeEvenIfAClientDoesNotListen) {
  Served served;
  auto deaf = served.client();
  ASSERT_TRUE(deaf);
  ASSERT_NE(served.capture_when_wanted(5'000'000), 0u);  // More than the sockets buffer.
  const auto before = std::chrono::steady_clock::now();
  served.server().end("the camera is gone");
  EXPECT_TRUE(eventually([&] { return served.is_done(); }));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 2s);
}

TEST(Loopback, RestsWithoutClients) {
  Served served;
  EXPECT_FALSE(served.server().wants_frames());
  EXPECT_FALSE(served.server().take_keyframe_request());
  EXPECT_EQ(served.capture(), 0u);
}

TEST(Loopback, WaitsNoLongerThanItIsToldAndGoesOnAfterwards) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  const auto none = client->receive({}, std::chrono::steady_clock::now() + 20ms);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(none.error().what, HasSubstr("sends no pictures"));
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}, std::chrono::steady_clock::now() + 5s));
}

TEST(Loopback, StopsWaitingWhenAskedAndGoesOnAfterwards) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  std::stop_source stop;
  std::jthread soon([&] {
    std::this_thread::sleep_for(20ms);
    stop.request_stop();
  });
  EXPECT_FALSE(client->receive(stop.get_token()));
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}));
}

TEST(Loopback, PausesTheEncoderOnlyWhenNobodyWantsAFrame) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  for (int i = 0; i < 2; ++i) ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(eventually([&] { return !served.server().wants_frames(); }));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(served.capture(), 0u);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(client->receive({}));
  const std::uint64_t next = served.capture_when_wanted();
  EXPECT_EQ(next, 2u + 6u);
  const auto received = client->receive({});
  ASSERT_TRUE(received);
  EXPECT_FALSE(received->frame.keyframe) << "nothing was encoded that it does not have";
  EXPECT_EQ(received->counters.window_full, 5u);
}

TEST(Loopback, SurvivesClientsThatVanish) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  {
    RawPeer killed(served.address());
    killed.say(encode(Hello{}));
    ASSERT_TRUE(killed.hear());
    ASSERT_NE(served.capture_when_wanted(100000), 0u);
    killed.vanish();
  }
  ASSERT_TRUE(client->receive({}));
  EXPECT_TRUE(eventually([&] { return served.server().counters().clients == 1; }));
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}));
}

TEST(Loopback, NoticesThatItsServerVanished) {
  auto served = std::make_unique<Served>();
  auto client = served->client();
  ASSERT_TRUE(client);
  served.reset();
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(received.error().what, HasSubstr("hung up"));
  EXPECT_FALSE(client->receive({})) << "and stays that way";
}

TEST(Loopback, ConnectsAnewToAServersSuccessor) {
  const auto socket = listen("127.0.0.1:0", Reach::kThisMachine);  // The parent process owns this socket.
  ASSERT_TRUE(socket);
  for (int life = 0; life < 3; ++life) {
    Served served(*socket);
    auto client = served.client();
    ASSERT_TRUE(client) << client.error().what;
    ASSERT_NE(served.capture_when_wanted(), 0u);
    EXPECT_TRUE(client->receive({})->frame.keyframe);
  }
}

TEST(Loopback, RefusesAnotherVersionAndSaysWhatToDo) {
  Served served;
  RawPeer stranger(served.address());
  stranger.say(encode(Hello{kProtocolVersion + 1}));
  const auto answer = stranger.hear();
  ASSERT_TRUE(answer);
  const auto reject = decode_reject(body_of(*answer));
  ASSERT_TRUE(reject);
  EXPECT_EQ(reject->reason, RejectReason::kVersion);
  EXPECT_THAT(reject->text, HasSubstr("server speaks protocol version 7, this client 8"));
  EXPECT_THAT(reject->text, HasSubstr("same release"));
  EXPECT_FALSE(stranger.hear());
}

TEST(Loopback, RefusesOneClientTooMany) {
  Served served;
  std::vector<FrameClient> clients;
  for (std::size_t i = 0; i < room_for(Stage::kClient); ++i) {
    auto client = served.client();
    ASSERT_TRUE(client) << client.error().what;
    clients.push_back(std::move(*client));
  }
  const auto keyframe = std::make_shared<EncodedFrame>();
  keyframe->keyframe = true;
  keyframe->sequence = 1;
  keyframe->depth = {1};
  ASSERT_TRUE(eventually([&] { return served.server().counters().clients == clients.size(); }));
  served.server().send(keyframe, {1, 0, 0});
  for (FrameClient& client : clients) ASSERT_TRUE(client.receive({}));
  ASSERT_TRUE(eventually([&] { return !served.client(); })) << "all acknowledgements have arrived";
  const auto one_more = served.client();
  ASSERT_FALSE(one_more);
  EXPECT_EQ(one_more.error().code, ErrorCode::kUnavailable) << "one may leave: not final";
  EXPECT_THAT(one_more.error().what, HasSubstr("32 clients already"));
  clients.pop_back();
  EXPECT_TRUE(eventually([&] { return served.client().has_value(); }));
}

TEST(Loopback, HangsUpOnNonsenseAndOnNobodyElse) {
  Served served;
  auto client = served.client();
  ASSERT_TRUE(client);
  const Bytes hello = encode(Hello{});
  Bytes twice = hello;
  twice.insert(twice.end(), hello.begin(), hello.end());
  const auto after_hello = [&hello](const Bytes& message) {
    Bytes both = hello;
    both.insert(both.end(), message.begin(), message.end());
    return both;
  };
  std::vector<Bytes> nonsense = {
      twice,
      after_hello(encode(FrameAck{1})),                         // The server never sent this frame.
      after_hello(encode(Pong{})),                              // Only a server sends this.
      after_hello(encode(EndOfStream{std::string(500, 'x')})),  // Only a server sends this.
      after_hello({0xff, 0xff, 0xff, 0xff, 0x13, 0, 0, 0}),     // A body of 4 GiB.
      after_hello({0, 0, 0, 0, 99, 0, 0, 0}),                   // An unknown type.
      encode_keyframe_request(),                                // A message before Hello.
      Bytes(100000, 0xaa),
  };
  for (const Bytes& message : nonsense) {
    RawPeer peer(served.address());
    peer.say(message);
    peer.hear_out();  // Returns when the server closes the connection.
  }
  RawPeer browser(served.address());
  browser.say("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  browser.hear_out();

  RawPeer half(served.address());
  half.say(Bytes(hello.begin(), hello.begin() + 10));
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}));
}

TEST(Loopback, DoesNotQueueAnswersForWhoeverNeverReadsThem) {
  Served served;
  RawPeer flood(served.address());
  flood.say(encode(Hello{}));
  Bytes pings;
  for (int i = 0; i < 1000; ++i) {
    const Bytes ping = encode(Ping{at_ns(i)});
    pings.insert(pings.end(), ping.begin(), ping.end());
  }
  for (int i = 0; i < 1000; ++i) flood.say(pings);  // Fails silently once it is closed.
  EXPECT_TRUE(eventually([&] { return served.server().counters().clients == 0; }));
}

}  // namespace
}  // namespace copresence::wire
