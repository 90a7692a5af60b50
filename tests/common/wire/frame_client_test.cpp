// A client and servers that are none.

#include "common/wire/frame_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <future>
#include <thread>

#include "tests/common/wire/raw_peer.h"
#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// Listens and does with the first connection what a test wants.
class FakeServer {
 public:
  explicit FakeServer(std::function<void(RawPeer&)> behaviour) {
    thread_ = std::jthread([this, behaviour = std::move(behaviour)] {
      RawPeer peer(acceptor_);
      behaviour(peer);
    });
  }
  std::string address() const { return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }

  Result<FrameClient> client(std::chrono::milliseconds timeout = 2s) const {
    return FrameClient::connect(address(), timeout, {});
  }

 private:
  asio::io_context io_;
  asio::ip::tcp::acceptor acceptor_{io_, {asio::ip::address_v4::loopback(), 0}};
  std::jthread thread_;
};

Bytes frame_message() {
  const FrameHeadMessage head = encode(sample_frame_head());
  Bytes message(head.size() + 100, 7);
  std::copy(head.begin(), head.end(), message.begin());
  return message;
}

/// Says something right after a proper handshake and listens until the client hangs up.
auto welcomes_and_says(const Bytes& bytes) {
  return [bytes](RawPeer& peer) {
    peer.hear();
    peer.say(encode(sample_welcome()));
    peer.say(bytes);
    peer.hear_out();
  };
}

Error error_after_handshake(const Bytes& bytes) {
  FakeServer server(welcomes_and_says(bytes));
  auto client = server.client();
  if (!client) return client.error();
  const auto received = client->receive({});
  return received ? Error{ErrorCode::kInvalid, "no error"} : received.error();
}

Error error_of_connecting(const Bytes& answer) {
  FakeServer server([&](RawPeer& peer) {
    peer.hear();
    peer.say(answer);
    peer.hear_out();
  });
  const auto client = server.client();
  return client ? Error{ErrorCode::kInvalid, "no error"} : client.error();
}

TEST(FrameClient, SaysThatNothingListens) {
  std::string address;
  {
    asio::io_context io;
    asio::ip::tcp::acceptor gone(io, {asio::ip::address_v4::loopback(), 0});
    address = "127.0.0.1:" + std::to_string(gone.local_endpoint().port());
  }
  const auto client = FrameClient::connect(address, 2s, {});
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(client.error().what, HasSubstr(address + ": connection refused"));
}

TEST(FrameClient, RefusesWhatIsNoAddress) {
  const auto client = FrameClient::connect("kitchen", 2s, {});
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().code, ErrorCode::kInvalid);
}

TEST(FrameClient, DoesNotWaitForeverForAWelcome) {
  FakeServer silent([](RawPeer& peer) { peer.hear_out(); });
  const auto client = silent.client(100ms);
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(client.error().what, HasSubstr("does not answer"));
}

TEST(FrameClient, StopsConnectingWhenAsked) {
  FakeServer silent([](RawPeer& peer) { peer.hear_out(); });
  std::stop_source stop;
  std::jthread soon([&] {
    std::this_thread::sleep_for(20ms);
    stop.request_stop();
  });
  const auto before = std::chrono::steady_clock::now();
  EXPECT_FALSE(FrameClient::connect(silent.address(), 10s, stop.get_token()));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
}

TEST(FrameClient, TakesARefusalOfItsVersionAsFinal) {
  const Error error = error_of_connecting(encode(Reject{RejectReason::kVersion, "install the same release"}));
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.what, HasSubstr("install the same release"));
}

TEST(FrameClient, TakesARefusalThatItDoesNotKnowAsFinal) {
  const Error error = error_of_connecting(encode(Reject{RejectReason{200}, "the room is closed for good"}));
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.what, HasSubstr("the room is closed for good"));
}

TEST(FrameClient, TakesAFullServerAsPassing) {
  EXPECT_EQ(error_of_connecting(encode(Reject{RejectReason::kFull, "full"})).code, ErrorCode::kUnavailable);
}

TEST(FrameClient, BelievesNoServerThatTalksNonsense) {
  EXPECT_EQ(error_of_connecting(Bytes(1000, 0xaa)).code, ErrorCode::kCorrupt);
  EXPECT_EQ(error_of_connecting(encode(Hello{})).code, ErrorCode::kCorrupt);
  EXPECT_EQ(error_of_connecting(frame_message()).code, ErrorCode::kCorrupt) << "before any welcome";
  EXPECT_THAT(error_of_connecting({'S', 'S', 'H', '-', '2', '.', '0', '-'}).what,
              HasSubstr("no capture_server"));
  EXPECT_EQ(error_after_handshake(Bytes(1000, 0xaa)).code, ErrorCode::kCorrupt);
  EXPECT_EQ(error_after_handshake(encode(sample_welcome())).code, ErrorCode::kCorrupt) << "twice";
  EXPECT_EQ(error_after_handshake(encode(Pong{at_ns(1), at_ns(2)})).code, ErrorCode::kCorrupt)
      << "never pinged";
  Bytes impossible = frame_message();
  impossible[kHeaderBytes + 61] = 1;  // more depth than bytes
  EXPECT_EQ(error_after_handshake(impossible).code, ErrorCode::kCorrupt);
}

TEST(FrameClient, SurvivesEveryEndInTheMiddleOfAMessage) {
  const Bytes frame = frame_message();
  for (const std::size_t size : {0u, 1u, 7u, 8u, 40u, 71u, 72u, 100u, 171u}) {
    FakeServer server([&](RawPeer& peer) {
      peer.hear();
      peer.say(encode(sample_welcome()));
      peer.say(Bytes(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)));
    });
    auto client = server.client();
    ASSERT_TRUE(client);
    const auto received = client->receive({});
    ASSERT_FALSE(received);
    EXPECT_EQ(received.error().code, ErrorCode::kUnavailable) << "after " << size << " bytes";
  }
}

TEST(FrameClient, AcknowledgesEachFrameAsItArrives) {
  std::optional<Bytes> ack;
  {
    FakeServer server([&](RawPeer& peer) {
      peer.hear();
      peer.say(encode(sample_welcome()));
      peer.say(frame_message());
      ack = peer.hear();
    });
    auto client = server.client();
    ASSERT_TRUE(client);
    ASSERT_TRUE(client->receive({}));
  }
  ASSERT_TRUE(ack);
  EXPECT_EQ(*ack, encode(FrameAck{300}));
}

TEST(FrameClient, SaysWhenAFrameArrivedHoweverLateItIsRead) {
  // The kernel begins to note arrivals a moment after the first socket asks for it, so the first try may come too early.
  std::chrono::steady_clock::duration noticed_before_reading{};
  for (int attempt = 0; attempt < 5 && noticed_before_reading < 20ms; ++attempt) {
    std::promise<void> sent;
    FakeServer server([&](RawPeer& peer) {
      peer.hear();
      peer.say(encode(sample_welcome()));
      peer.say(frame_message());
      sent.set_value();
      peer.hear_out();
    });
    auto client = server.client();
    ASSERT_TRUE(client);
    sent.get_future().wait();
    std::this_thread::sleep_for(100ms);  // the client is busy with another frame
    const auto read_from = std::chrono::steady_clock::now();
    const auto received = client->receive({});
    ASSERT_TRUE(received);
    noticed_before_reading = read_from - received->received_at;
  }
  EXPECT_GE(noticed_before_reading, 20ms);
}

TEST(FrameClient, DoesNotCountItsOwnPausesAsRoundTrips) {
  constexpr auto kPause = 200ms;
  FakeServer server([&](RawPeer& peer) {
    peer.hear();
    std::this_thread::sleep_for(2 * kPause);  // the handshake alone tells little about the clock
    peer.say(encode(sample_welcome()));
    while (const auto message = peer.hear()) {
      if (type_of(*message) != MessageType::kPing) continue;
      peer.say(frame_message());  // the client turns to this and reads the answer later
      peer.say(encode(Pong{decode_ping(body_of(*message))->client_time, std::chrono::steady_clock::now()}));
    }
  });
  auto client = server.client();
  ASSERT_TRUE(client);
  EXPECT_GE(client->clock().uncertainty, kPause);
  for (int frames = 0; frames < 4; ++frames) {
    ASSERT_TRUE(client->receive({}));
    std::this_thread::sleep_for(kPause);
  }
  EXPECT_LT(client->clock().uncertainty, kPause / 4);
}

TEST(FrameClient, TakesNoFloodOfNoticesForACamera) {
  Bytes flood;
  for (int i = 0; i < 1000; ++i) {
    const Bytes status = encode(CameraStatus{"unplugged"});
    flood.insert(flood.end(), status.begin(), status.end());
  }
  FakeServer server(welcomes_and_says(flood));
  auto client = server.client();
  ASSERT_TRUE(client);
  int heard = 0;
  client->on_camera_status([&](const std::string&) { ++heard; });
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kCorrupt);
  EXPECT_LE(heard, 100);
}

TEST(FrameClient, GivesUpInTimeThoughTheServerNeverStopsTalking) {
  FakeServer server([](RawPeer& peer) {
    peer.hear();
    peer.say(encode(sample_welcome()));
    for (int i = 0; i < 50; ++i) {
      peer.say(encode(CameraStatus{"still unplugged"}));
      std::this_thread::sleep_for(10ms);
    }
    peer.hear_out();
  });
  auto client = server.client();
  ASSERT_TRUE(client);
  const auto received = client->receive({}, std::chrono::steady_clock::now() + 100ms);
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kTimeout);
}

TEST(FrameClient, NamesAHostThatNobodyKnows) {
  const auto client = FrameClient::connect("no-such-host.invalid:7001", 2s, {});
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(client.error().what, HasSubstr("no-such-host.invalid:7001: no host has this name"));
}

TEST(FrameClient, ConnectsToAHostByName) {
  FakeServer server(welcomes_and_says(frame_message()));
  const std::string port = server.address().substr(server.address().find(':'));
  auto client = FrameClient::connect("localhost" + port, 2s, {});
  ASSERT_TRUE(client) << client.error().what;
  EXPECT_TRUE(client->receive({}));
}

TEST(FrameClient, FollowsTheClockOfAnotherMachine) {
  constexpr auto kAhead = 1000s;
  FakeServer server([&](RawPeer& peer) {
    peer.hear();
    Welcome welcome = sample_welcome();
    welcome.server_time = std::chrono::steady_clock::now() + kAhead;
    peer.say(encode(welcome));
    for (int pings = 0; pings < 2;) {
      const auto message = peer.hear();
      if (!message) return;
      if (type_of(*message) != MessageType::kPing) continue;
      const auto ping = decode_ping(body_of(*message));
      peer.say(encode(Pong{ping->client_time, std::chrono::steady_clock::now() + kAhead}));
      ++pings;
    }
    peer.say(encode(EndOfStream{"done"}));
    peer.hear_out();
  });
  auto client = server.client();
  ASSERT_TRUE(client);
  const auto holds = [&] {
    const ClockOffset clock = client->clock();
    return clock.uncertainty > Duration::zero() &&
           std::chrono::abs(clock.offset - kAhead) <= clock.uncertainty;
  };
  EXPECT_TRUE(holds()) << "from the handshake alone";
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kEndOfStream);
  EXPECT_TRUE(holds());
}

}  // namespace
}  // namespace copresence::wire
