// Server and clients over 127.0.0.1, in one process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "common/wire/frame_client.h"
#include "common/wire/frame_server.h"
#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// A server on a free port, its wire thread, and a camera that captures when told.
class Served {
 public:
  Served() : Served(*listen("127.0.0.1:0", false)) {}
  explicit Served(const ListeningSocket& socket)
      : address_(socket.address()), server_(*FrameServer::open(socket, sample_description())) {
    wire_ = std::jthread([this](std::stop_token stop) { server_->run(stop); });
  }

  FrameServer& server() { return *server_; }
  const std::string& address() const { return address_; }

  /// One frame as a pipeline makes it: encoded only if wanted. Whether it was.
  bool capture(std::size_t depth_bytes = 1000) {
    ++counters_.captured;
    if (!server_->wants_frames()) {
      ++counters_.window_full;
      return false;
    }
    auto frame = std::make_shared<EncodedFrame>();
    frame->keyframe = server_->take_keyframe_request();
    frame->sequence = counters_.captured;
    frame->depth.assign(depth_bytes, static_cast<std::uint8_t>(frame->sequence));
    frame->color.assign(depth_bytes / 2, 0x55);
    server_->send(frame, counters_);
    return true;
  }

  template <class Condition>
  bool eventually(const Condition& condition) {
    for (int i = 0; i < 2000 && !condition(); ++i) std::this_thread::sleep_for(1ms);
    return condition();
  }

 private:
  std::string address_;
  std::unique_ptr<FrameServer> server_;
  FrameCounters counters_;
  std::jthread wire_;
};

Result<FrameClient> client_of(const Served& served) {
  return FrameClient::connect(served.address(), 2s, {});
}

TEST(Loopback, CarriesAFrameAsItIs) {
  Served served;
  auto client = client_of(served);
  ASSERT_TRUE(client) << client.error().what;
  EXPECT_EQ(client->description(), sample_description());
  EXPECT_EQ(client->clock(), ClockOffset{});
  ASSERT_TRUE(served.eventually([&] { return served.server().wants_frames(); }));
  ASSERT_TRUE(served.capture(50000));
  const auto received = client->receive({});
  ASSERT_TRUE(received) << received.error().what;
  EXPECT_TRUE(received->frame.keyframe);
  EXPECT_EQ(received->frame.sequence, 1u);
  EXPECT_EQ(received->frame.depth, std::vector<std::uint8_t>(50000, 1));
  EXPECT_EQ(received->frame.color, std::vector<std::uint8_t>(25000, 0x55));
  EXPECT_EQ(received->counters, (FrameCounters{1, 0, 0}));
  EXPECT_LE(received->sent_at, received->received_at);
  EXPECT_GT(client->bytes_received(), 75000u);
}

TEST(Loopback, TellsWhyAStreamEnds) {
  Served served;
  auto client = client_of(served);
  ASSERT_TRUE(client);
  served.server().end("the recording is over");
  const auto received = client->receive({});
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(received.error().what, "the recording is over");
}

TEST(Loopback, RestsWithoutClients) {
  Served served;
  EXPECT_FALSE(served.server().wants_frames());
  EXPECT_FALSE(served.capture());
}

TEST(Loopback, StopsWaitingWhenAsked) {
  Served served;
  auto client = client_of(served);
  ASSERT_TRUE(client);
  std::stop_source stop;
  std::jthread soon([&] {
    std::this_thread::sleep_for(50ms);
    stop.request_stop();
  });
  const auto before = std::chrono::steady_clock::now();
  EXPECT_FALSE(client->receive(stop.get_token()));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
}

}  // namespace
}  // namespace copresence::wire
