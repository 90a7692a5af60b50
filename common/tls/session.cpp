#include "common/tls/session.h"

#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <string_view>
#include <utility>

namespace copresence::tls {
namespace {

template <auto kFree>
struct Free {
  template <class T>
  void operator()(T* object) const {
    kFree(object);
  }
};
using ContextOwner = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;
using PskOwner = std::unique_ptr<SSL_SESSION, Free<SSL_SESSION_free>>;
using SslOwner = std::unique_ptr<SSL, Free<SSL_free>>;
using MethodOwner = std::unique_ptr<BIO_METHOD, Free<BIO_meth_free>>;

constexpr const char* kCipherSuite = "TLS_AES_128_GCM_SHA256";
constexpr const char* kGroup = "X25519";
/// The name of the key in the handshake. It is not secret, and the same for all rooms, so that it
/// does not show which connections belong to one room.
constexpr std::string_view kIdentity = "copresence";
constexpr std::array<unsigned char, 2> kCipherId = {0x13, 0x01};  // RFC 8446, appendix B.4

/// The pre-shared key in the form that OpenSSL takes: a session that could be resumed.
PskOwner make_psk(SSL_CTX* context, const RoomKey& key) {
  const SslOwner ssl(SSL_new(context));
  PskOwner psk(SSL_SESSION_new());
  const SSL_CIPHER* cipher = ssl ? SSL_CIPHER_find(ssl.get(), kCipherId.data()) : nullptr;
  if (!psk || !cipher || !SSL_SESSION_set1_master_key(psk.get(), key.bytes().data(), RoomKey::kBytes) ||
      !SSL_SESSION_set_cipher(psk.get(), cipher) ||
      !SSL_SESSION_set_protocol_version(psk.get(), TLS1_3_VERSION)) {
    return nullptr;
  }
  return psk;
}

SSL_SESSION* shared_psk(SSL* ssl) {
  auto* psk = static_cast<SSL_SESSION*>(SSL_CTX_get_app_data(SSL_get_SSL_CTX(ssl)));
  SSL_SESSION_up_ref(psk);
  return psk;
}

int offer_psk(SSL* ssl, const EVP_MD*, const unsigned char** identity, std::size_t* identity_size,
              SSL_SESSION** psk) {
  *identity = reinterpret_cast<const unsigned char*>(kIdentity.data());
  *identity_size = kIdentity.size();
  *psk = shared_psk(ssl);
  return 1;
}

int find_psk(SSL* ssl, const unsigned char* identity, std::size_t identity_size, SSL_SESSION** psk) {
  const std::string_view offered(reinterpret_cast<const char*>(identity), identity_size);
  *psk = offered == kIdentity ? shared_psk(ssl) : nullptr;
  return 1;
}

/// A carrier, and how it has ended.
struct Link {
  Carrier& carrier;
  bool has_ended = false;  // Its stream is at its end.
};

Link& link_of(BIO* bio) {
  return *static_cast<Link*>(BIO_get_data(bio));
}

int receive(BIO* bio, char* to, int size) {
  BIO_clear_retry_flags(bio);
  Link& link = link_of(bio);
  const auto got =
      link.carrier.receive({reinterpret_cast<std::uint8_t*>(to), static_cast<std::size_t>(size)});
  if (got < 0 && errno == EAGAIN) BIO_set_retry_read(bio);
  if (got == 0) link.has_ended = true;
  return static_cast<int>(got);
}

int send(BIO* bio, const char* from, int size) {
  BIO_clear_retry_flags(bio);
  const auto sent = link_of(bio).carrier.send(
      {reinterpret_cast<const std::uint8_t*>(from), static_cast<std::size_t>(size)});
  if (sent < 0 && errno == EAGAIN) BIO_set_retry_write(bio);
  return static_cast<int>(sent);
}

long control(BIO*, int command, long, void*) {
  return command == BIO_CTRL_FLUSH ? 1 : 0;  // Nothing is buffered.
}

/// Returns OpenSSL's functions for a carrier, or null without memory.
const BIO_METHOD* carrier_method() {
  static const MethodOwner method = [] {
    MethodOwner made(BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "carrier"));
    BIO_meth_set_read(made.get(), receive);
    BIO_meth_set_write(made.get(), send);
    BIO_meth_set_ctrl(made.get(), control);
    return made;
  }();
  return method.get();
}

}  // namespace

struct Context::State {
  ContextOwner context;
  PskOwner psk;
  Side side;
};

Context::Context(std::unique_ptr<State> state) : state_(std::move(state)) {}
Context::Context(Context&&) noexcept = default;
Context& Context::operator=(Context&&) noexcept = default;
Context::~Context() = default;

Result<Context> Context::make(Side side, const RoomKey& key) {
  const auto unsupported = [] {
    return fail(ErrorCode::kUnsupported,
                fmt::format("the installed OpenSSL does not offer TLS 1.3 with {}", kCipherSuite));
  };
  auto state = std::make_unique<State>();
  state->side = side;
  state->context.reset(SSL_CTX_new(side == Side::kClient ? TLS_client_method() : TLS_server_method()));
  SSL_CTX* const context = state->context.get();
  if (!context || !SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) ||
      !SSL_CTX_set_max_proto_version(context, TLS1_3_VERSION) ||
      !SSL_CTX_set_ciphersuites(context, kCipherSuite) || !SSL_CTX_set1_groups_list(context, kGroup)) {
    return unsupported();
  }
  SSL_CTX_set_options(context, SSL_OP_NO_TICKET);
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                SSL_MODE_RELEASE_BUFFERS);
  state->psk = make_psk(context, key);
  if (!state->psk) return unsupported();
  SSL_CTX_set_app_data(context, state->psk.get());
  if (side == Side::kClient) {
    // No authority is trusted, so a server that shows a certificate instead of the key is rejected.
    SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
    SSL_CTX_set_psk_use_session_callback(context, offer_psk);
  } else {
    SSL_CTX_set_psk_find_session_callback(context, find_psk);
  }
  return Context(std::move(state));
}

struct Session::State {
  Link link;
  SslOwner ssl;
  std::uint64_t records = 0;  // Written since the handshake.

  /// Says how a call of OpenSSL ended that returned `result`.
  Outcome outcome_of(int result) const;
  Outcome outcome_of_handshake(int result) const;
};

Session::Session(const Context& context, Carrier& carrier)
    : state_(new State{Link{carrier}, SslOwner(SSL_new(context.state_->context.get()))}) {
  BIO* const bio = BIO_new(carrier_method());
  assert(state_->ssl && bio);  // Running out of memory ends the program.
  BIO_set_data(bio, &state_->link);
  BIO_set_init(bio, 1);
  SSL_set_bio(state_->ssl.get(), bio, bio);
  if (context.state_->side == Side::kClient) {
    SSL_set_connect_state(state_->ssl.get());
  } else {
    SSL_set_accept_state(state_->ssl.get());
  }
}

Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Outcome Session::State::outcome_of(int result) const {
  switch (SSL_get_error(ssl.get(), result)) {
    case SSL_ERROR_NONE:
      return Outcome::kDone;
    case SSL_ERROR_WANT_READ:
      return Outcome::kMustReceive;
    case SSL_ERROR_WANT_WRITE:
      return Outcome::kMustSend;
    case SSL_ERROR_ZERO_RETURN:
      return Outcome::kEnded;
    case SSL_ERROR_SYSCALL:
      return link.has_ended ? Outcome::kEnded : Outcome::kCarrierFailed;
    default:
      return link.has_ended ? Outcome::kEnded : Outcome::kBroken;
  }
}

Outcome Session::State::outcome_of_handshake(int result) const {
  const Outcome outcome = outcome_of(result);
  if (outcome == Outcome::kDone) {
    // A server could have chosen to ignore the key.
    return SSL_session_reused(ssl.get()) ? Outcome::kDone : Outcome::kWrongKey;
  }
  if (outcome != Outcome::kBroken) return outcome;
  switch (ERR_GET_REASON(ERR_peek_error())) {
    case SSL_R_BINDER_DOES_NOT_VERIFY:     // At the server.
    case SSL_R_CERTIFICATE_VERIFY_FAILED:  // At the client: the server shows a certificate instead of the key.
    // At the client: the server's alert that rejects the key. A server with OpenSSL sends the first.
    case SSL_AD_REASON_OFFSET + SSL_AD_ILLEGAL_PARAMETER:
    case SSL_AD_REASON_OFFSET + SSL_AD_DECRYPT_ERROR:
    case SSL_AD_REASON_OFFSET + SSL_AD_UNKNOWN_PSK_IDENTITY:
      return Outcome::kWrongKey;
    default:
      return Outcome::kBroken;
  }
}

Outcome Session::handshake() {
  ERR_clear_error();
  return state_->outcome_of_handshake(SSL_do_handshake(state_->ssl.get()));
}

Outcome Session::read(std::span<std::uint8_t> to, std::size_t& got) {
  assert(!to.empty());
  ERR_clear_error();
  return state_->outcome_of(SSL_read_ex(state_->ssl.get(), to.data(), to.size(), &got));
}

Outcome Session::write(std::span<const std::uint8_t> from, std::size_t& taken) {
  assert(!from.empty());
  ERR_clear_error();
  SSL* const ssl = state_->ssl.get();
  const Outcome outcome =
      state_->outcome_of(SSL_write_ex(ssl, from.data(), std::min(from.size(), kMostInRecord), &taken));
  if (outcome == Outcome::kDone && ++state_->records % kRecordsOfAKey == 0)
    SSL_key_update(ssl, SSL_KEY_UPDATE_NOT_REQUESTED);
  return outcome;
}

void Session::end_writing() {
  ERR_clear_error();
  SSL_shutdown(state_->ssl.get());
}

}  // namespace copresence::tls
