// Clients and servers with and without a room key.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "common/tls/session.h"
#include "tests/common/wire/raw_peer.h"
#include "tests/common/wire/served.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

tls::RoomKey key_of(std::uint8_t byte) {
  std::array<std::uint8_t, tls::RoomKey::kBytes> bytes;
  bytes.fill(byte);
  return tls::RoomKey(bytes);
}

const tls::RoomKey kKey = key_of(0x5a), kOther = key_of(0xa5);

Error error_of(const Result<FrameClient>& client) {
  return client ? Error{ErrorCode::kInvalid, "no error"} : client.error();
}

/// The bytes with which a client with `key` begins: its ClientHello.
Bytes client_hello(const tls::RoomKey& key) {
  struct Recorder final : tls::Carrier {
    std::ptrdiff_t receive(std::span<std::uint8_t>) override {
      errno = EAGAIN;
      return -1;
    }
    std::ptrdiff_t send(std::span<const std::uint8_t> from) override {
      sent.insert(sent.end(), from.begin(), from.end());
      return static_cast<std::ptrdiff_t>(from.size());
    }
    Bytes sent;
  } recorder;
  const tls::Context context = *tls::Context::make(tls::Side::kClient, key);
  tls::Session session(context, recorder);
  EXPECT_EQ(session.handshake(), tls::Outcome::kMustReceive);
  return recorder.sent;
}

TEST(Encryption, CarriesFramesOfAllSizes) {
  Served served(&kKey);
  auto client = served.client(&kKey);
  ASSERT_TRUE(client) << client.error().what;
  for (const std::size_t bytes : {1u, 1000u, 16384u, 16385u, 700'000u, 3'000'000u}) {
    const std::uint64_t sequence = served.capture_when_wanted(bytes);
    ASSERT_NE(sequence, 0u);
    const auto received = client->receive({});
    ASSERT_TRUE(received) << received.error().what;
    EXPECT_EQ(received->frame.sequence, sequence);
    EXPECT_EQ(received->frame.depth, std::vector<std::uint8_t>(bytes, static_cast<std::uint8_t>(sequence)));
    EXPECT_EQ(received->frame.color, std::vector<std::uint8_t>(bytes / 2, 0x55));
  }
  EXPECT_EQ(client->clock().offset, Duration::zero()) << "one machine has one clock";
  EXPECT_GT(client->bytes_received(), 5'000'000u);
}

TEST(Encryption, TellsTheReasonOfTheEnd) {
  Served served(&kKey);
  auto client = served.client(&kKey);
  ASSERT_TRUE(client);
  ASSERT_NE(served.capture_when_wanted(), 0u);
  served.server().end("the recording is over");
  ASSERT_TRUE(client->receive({}));
  const auto end = client->receive({});
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(end.error().what, "the recording is over");
  EXPECT_TRUE(eventually([&] { return served.is_done(); }));
}

TEST(Encryption, SaysWhenAFrameArrivedHoweverLateItIsRead) {
  // As FrameClient.SaysWhenAFrameArrivedHoweverLateItIsRead. A pong that comes while the client
  // decrypts may be merged with a record of the frame. So it takes more attempts.
  Duration noticed_before_reading{};
  for (int attempt = 0; attempt < 20 && noticed_before_reading < 20ms; ++attempt) {
    Served served(&kKey);
    auto client = served.client(&kKey);
    ASSERT_TRUE(client);
    for (int frame = 0; frame < 2; ++frame) ASSERT_NE(served.capture_when_wanted(20'000), 0u);
    std::this_thread::sleep_for(100ms);  // The client is busy with another frame.
    const auto read_from = std::chrono::steady_clock::now();
    const auto received = client->receive({});
    ASSERT_TRUE(received);
    noticed_before_reading = read_from - received->received_at;
  }
  EXPECT_GE(noticed_before_reading, 20ms);
}

TEST(Encryption, AWrongKeyIsFinalAndSaidInOneSentence) {
  Served served(&kKey);
  const Error error = error_of(served.client(&kOther));
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_EQ(error.what, served.address() +
                            ": the server has another room key: give --key FILE with a copy of the server's "
                            "key file");
}

TEST(Encryption, AMissingKeyIsFinalAndSaidInOneSentence) {
  Served served(&kKey);
  const Error error = error_of(served.client());
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.what, HasSubstr("this server needs the room's key: give --key FILE"));
}

TEST(Encryption, AServerWithoutAKeyIsNotWatchedWithOne) {
  Served served;
  const Error error = error_of(served.client(&kKey));
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.what, HasSubstr("the server has no key: start the client without --key"));
  EXPECT_TRUE(served.client()) << "without a key it is";
}

TEST(Encryption, AClientWithAKeyBelievesNothingThatIsNotEncrypted) {
  for (const Bytes& answer :
       {encode(sample_welcome()), Bytes{'S', 'S', 'H', '-', '2', '.', '0', '-', 'x', '\n'}}) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    std::jthread impostor([&] {
      RawPeer peer(acceptor);
      peer.say(answer);
      peer.hear_out();
    });
    const std::string address = "127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
    const Error error = error_of(FrameClient::connect(address, 2s, {}, &kKey));
    EXPECT_EQ(error.code, ErrorCode::kCorrupt) << "another program may have the port for a while";
  }
}

TEST(Encryption, StrangersGetNothingAndDoNotDisturbAViewer) {
  Served served(&kKey);
  auto client = served.client(&kKey);
  ASSERT_TRUE(client);
  const Bytes hello = client_hello(kKey);
  Bytes large = hello;
  large[3] = 0x3f;  // A record of 16 KiB.
  for (const Bytes& opening : {client_hello(kOther), large, Bytes(3000, 0xaa), Bytes(3000, 0x16)}) {
    RawPeer stranger(served.address());
    stranger.say(opening);
    stranger.hear_out();
  }
  RawPeer half(served.address()), replayed(served.address()), silent(served.address());
  half.say(Bytes(hello.begin(), hello.begin() + 100));
  replayed.say(hello);
  ASSERT_NE(served.capture_when_wanted(), 0u);
  EXPECT_TRUE(client->receive({}));
  const auto second = served.client(&kKey);
  ASSERT_TRUE(second);
  EXPECT_TRUE(eventually([&] { return served.server().counters().clients == 2; }));
}

TEST(Encryption, AClientHelloThatArrivesByteByByteIsAccepted) {
  Served served(&kKey);
  RawPeer slow(served.address());
  for (const std::uint8_t byte : client_hello(kKey)) {
    slow.say(Bytes{byte});
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(slow.hear_byte(), 22) << "the server's handshake";
}

}  // namespace
}  // namespace copresence::wire
