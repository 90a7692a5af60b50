#include "common/tls/session.h"

#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cerrno>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace copresence::tls {
namespace {

using Bytes = std::vector<std::uint8_t>;

RoomKey key_of(std::uint8_t first) {
  std::array<std::uint8_t, RoomKey::kBytes> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(first + i);
  return RoomKey(bytes);
}

const RoomKey kKey = key_of(1), kOther = key_of(2);

/// One direction of a connection in memory.
struct Direction {
  Bytes waiting;                   // Sent and not received yet.
  Bytes all;                       // Everything that was ever sent.
  std::size_t capacity = 1 << 20;  // Most bytes that wait.
  bool has_ended = false;
};

class Memory final : public Carrier {
 public:
  Memory(Direction& in, Direction& out) : in_(in), out_(out) {}
  std::ptrdiff_t receive(std::span<std::uint8_t> to) override {
    const std::size_t count = std::min(to.size(), in_.waiting.size());
    if (count == 0) return in_.has_ended ? 0 : wait();
    std::copy_n(in_.waiting.begin(), count, to.begin());
    in_.waiting.erase(in_.waiting.begin(), in_.waiting.begin() + static_cast<std::ptrdiff_t>(count));
    return static_cast<std::ptrdiff_t>(count);
  }
  std::ptrdiff_t send(std::span<const std::uint8_t> from) override {
    const std::size_t count = std::min(from.size(), out_.capacity - out_.waiting.size());
    if (count == 0) return wait();
    out_.waiting.insert(out_.waiting.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    out_.all.insert(out_.all.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    return static_cast<std::ptrdiff_t>(count);
  }

 private:
  static std::ptrdiff_t wait() {
    errno = EAGAIN;
    return -1;
  }
  Direction &in_, &out_;
};

bool must_wait(Outcome outcome) {
  return outcome == Outcome::kMustReceive || outcome == Outcome::kMustSend;
}

/// A client and a server that are connected in memory.
class Pair {
 public:
  Pair(const RoomKey& client_key, const RoomKey& server_key)
      : client_context_(*Context::make(Side::kClient, client_key)),
        server_context_(*Context::make(Side::kServer, server_key)) {}

  /// Lets both ends shake hands until neither can go on. Returns the outcomes of client and server.
  std::pair<Outcome, Outcome> shake_hands() {
    std::pair<Outcome, Outcome> now{Outcome::kMustReceive, Outcome::kMustReceive};
    for (int i = 0; i < 10; ++i) {
      if (must_wait(now.first)) now.first = client.handshake();
      if (must_wait(now.second)) now.second = server.handshake();
    }
    return now;
  }

 private:
  Context client_context_, server_context_;

 public:
  Direction to_server, to_client;

 private:
  Memory at_client_{to_client, to_server}, at_server_{to_server, to_client};

 public:
  Session client{client_context_, at_client_}, server{server_context_, at_server_};
};

const std::pair kBothDone{Outcome::kDone, Outcome::kDone};

/// Sends all bytes through the pair and returns what has arrived.
Bytes carried(Session& from, Session& to, const Bytes& bytes) {
  Bytes arrived;
  std::size_t sent = 0;
  for (int idle = 0; arrived.size() < bytes.size() && idle < 1000; ++idle) {
    if (sent < bytes.size()) {
      std::size_t taken = 0;
      if (from.write(std::span(bytes).subspan(sent), taken) == Outcome::kDone) sent += taken;
    }
    Bytes part(5000);
    std::size_t got = 0;
    while (to.read(part, got) == Outcome::kDone) {
      arrived.insert(arrived.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got));
      idle = 0;
    }
  }
  return arrived;
}

Bytes picture(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 2654435761u >> 13);
  return bytes;
}

bool contains(const Bytes& all, const Bytes& part) {
  return std::search(all.begin(), all.end(), part.begin(), part.end()) != all.end();
}

TEST(TlsSession, CarriesBytesBothWaysBetweenEndsWithTheSameKey) {
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  const Bytes bytes = picture(100'000);
  EXPECT_EQ(carried(pair.client, pair.server, bytes), bytes);
  EXPECT_EQ(carried(pair.server, pair.client, bytes), bytes);
}

TEST(TlsSession, CarriesBytesThroughACarrierThatTakesFewAtATime) {
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  pair.to_client.capacity = 777;
  const Bytes bytes = picture(100'000);
  EXPECT_EQ(carried(pair.server, pair.client, bytes), bytes);
}

TEST(TlsSession, ShowsNothingOfBytesAndKey) {
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  const Bytes bytes(1000, 'x');
  ASSERT_EQ(carried(pair.server, pair.client, bytes), bytes);
  EXPECT_GT(pair.to_client.all.size(), bytes.size());
  EXPECT_FALSE(contains(pair.to_client.all, Bytes(8, 'x')));
  const auto key = kKey.bytes();
  for (const Direction* direction : {&pair.to_server, &pair.to_client}) {
    EXPECT_FALSE(contains(direction->all, Bytes(key.begin(), key.begin() + 8)));
  }
}

TEST(TlsSession, BothEndsNoticeAnotherKey) {
  Pair pair(kKey, kOther);
  EXPECT_EQ(pair.shake_hands(), (std::pair{Outcome::kWrongKey, Outcome::kWrongKey}));
}

TEST(TlsSession, SendsNoTicketsAfterTheHandshake) {
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  EXPECT_TRUE(pair.to_client.waiting.empty());
}

TEST(TlsSession, ChangesItsKeyAfterManyRecords) {
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  const std::size_t before = pair.to_client.all.size();
  constexpr std::size_t kWrites = 2 * Session::kRecordsOfAKey + 5;
  for (std::size_t i = 0; i < kWrites; ++i) {
    const Bytes sent{static_cast<std::uint8_t>(i)};
    Bytes arrived{0};
    std::size_t count = 0;
    ASSERT_EQ(pair.server.write(sent, count), Outcome::kDone);
    ASSERT_EQ(pair.client.read(arrived, count), Outcome::kDone);
    ASSERT_EQ(arrived, sent);
  }
  constexpr std::size_t kRecord = 5 + 1 + 1 + 16;     // Header, byte, type, tag: RFC 8446, section 5.2.
  constexpr std::size_t kKeyUpdate = 5 + 5 + 1 + 16;  // A message of 5 bytes in a record.
  EXPECT_EQ(pair.to_client.all.size() - before, kWrites * kRecord + 2 * kKeyUpdate);
}

TEST(TlsSession, NoticesEachChangedByteOfARecord) {
  for (const std::size_t at : {0u, 3u, 5u, 60u, 120u}) {
    Pair pair(kKey, kKey);
    ASSERT_EQ(pair.shake_hands(), kBothDone);
    const Bytes bytes = picture(100);
    std::size_t count = 0;
    ASSERT_EQ(pair.server.write(bytes, count), Outcome::kDone);
    pair.to_client.waiting.at(at) ^= 0x80;
    Bytes to(200);
    const Outcome outcome = pair.client.read(to, count);
    EXPECT_TRUE(outcome == Outcome::kBroken || outcome == Outcome::kMustReceive) << at;
  }
}

TEST(TlsSession, EndsWhenThePeerEndsAndWhenTheCarrierIsCut) {
  Bytes to(10);
  std::size_t got = 0;
  Pair pair(kKey, kKey);
  ASSERT_EQ(pair.shake_hands(), kBothDone);
  EXPECT_EQ(pair.client.read(to, got), Outcome::kMustReceive);
  pair.server.end_writing();
  EXPECT_EQ(pair.client.read(to, got), Outcome::kEnded);
  EXPECT_EQ(pair.server.read(to, got), Outcome::kMustReceive) << "the other direction goes on";
  pair.to_server.has_ended = true;
  EXPECT_EQ(pair.server.read(to, got), Outcome::kEnded);
}

TEST(TlsSession, AHandshakeThatIsCutEnds) {
  Pair whole(kKey, kKey);
  ASSERT_EQ(whole.shake_hands(), kBothDone);
  for (std::size_t size = 0; size + 1 < whole.to_client.all.size(); size += 7) {
    Pair pair(kKey, kKey);
    ASSERT_EQ(pair.client.handshake(), Outcome::kMustReceive);
    ASSERT_EQ(pair.server.handshake(), Outcome::kMustReceive);
    pair.to_client.waiting.resize(size);
    pair.to_client.has_ended = true;
    ASSERT_EQ(pair.client.handshake(), Outcome::kEnded) << size;
  }
}

TEST(TlsSession, ReplayedBytesOfAClientAreNoProof) {
  Pair recorded(kKey, kKey);
  ASSERT_EQ(recorded.shake_hands(), kBothDone);
  Pair pair(kKey, kKey);
  pair.to_server.waiting = recorded.to_server.all;
  EXPECT_EQ(pair.server.handshake(), Outcome::kBroken);
}

/// An end that is not of this project, in memory.
class Foreign {
 public:
  Foreign(Side side, const std::function<void(SSL_CTX*)>& configure)
      : context_(SSL_CTX_new(side == Side::kClient ? TLS_client_method() : TLS_server_method())) {
    configure(context_);
    ssl_ = SSL_new(context_);
    SSL_set_bio(ssl_, BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
    side == Side::kClient ? SSL_set_connect_state(ssl_) : SSL_set_accept_state(ssl_);
  }
  ~Foreign() {
    SSL_free(ssl_);
    SSL_CTX_free(context_);
  }

  /// Shakes hands with an end of this project and returns how that fares.
  Outcome shake_hands(Side other_side) {
    const Context context = *Context::make(other_side, kKey);
    Direction in, out;
    Memory carrier(in, out);
    Session other(context, carrier);
    Outcome outcome = Outcome::kMustReceive;
    for (int i = 0; i < 10 && must_wait(outcome); ++i) {
      SSL_do_handshake(ssl_);
      Bytes sent(1 << 16);
      const int count = BIO_read(SSL_get_wbio(ssl_), sent.data(), static_cast<int>(sent.size()));
      if (count > 0) in.waiting.insert(in.waiting.end(), sent.begin(), sent.begin() + count);
      outcome = other.handshake();
      if (!out.waiting.empty())
        BIO_write(SSL_get_rbio(ssl_), out.waiting.data(), static_cast<int>(out.waiting.size()));
      out.waiting.clear();
    }
    SSL_do_handshake(ssl_);
    EXPECT_FALSE(SSL_is_init_finished(ssl_));
    return outcome;
  }

 private:
  SSL_CTX* context_;
  SSL* ssl_;
};

void use_own_certificate(SSL_CTX* context) {
  EVP_PKEY* const key = EVP_EC_gen("P-256");
  X509* const certificate = X509_new();
  ASN1_INTEGER_set(X509_get_serialNumber(certificate), 1);
  X509_gmtime_adj(X509_getm_notBefore(certificate), 0);
  X509_gmtime_adj(X509_getm_notAfter(certificate), 3600);
  X509_set_pubkey(certificate, key);
  X509_sign(certificate, key, EVP_sha256());
  SSL_CTX_use_certificate(context, certificate);
  SSL_CTX_use_PrivateKey(context, key);
  X509_free(certificate);
  EVP_PKEY_free(key);
}

TEST(TlsSession, AServerThatShowsACertificateInsteadOfTheKeyIsRejected) {
  Foreign impostor(Side::kServer, use_own_certificate);
  EXPECT_EQ(impostor.shake_hands(Side::kClient), Outcome::kWrongKey);
}

TEST(TlsSession, AServerOfOtherCiphersIsNotTakenForOneWithAnotherKey) {
  Foreign web_server(Side::kServer, [](SSL_CTX* context) {
    use_own_certificate(context);
    SSL_CTX_set_ciphersuites(context, "TLS_AES_256_GCM_SHA384");
  });
  EXPECT_EQ(web_server.shake_hands(Side::kClient), Outcome::kBroken);
}

TEST(TlsSession, AClientWithoutAKeyIsRejected) {
  for (const auto& configure : std::vector<std::function<void(SSL_CTX*)>>{
           [](SSL_CTX*) {}, [](SSL_CTX* context) { SSL_CTX_set_max_proto_version(context, TLS1_2_VERSION); },
           [](SSL_CTX* context) { SSL_CTX_set_ciphersuites(context, "TLS_AES_256_GCM_SHA384"); }}) {
    Foreign stranger(Side::kClient, configure);
    EXPECT_EQ(stranger.shake_hands(Side::kServer), Outcome::kBroken);
  }
}

}  // namespace
}  // namespace copresence::tls
