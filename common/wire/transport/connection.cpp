#include "common/wire/transport/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <utility>

#include "common/wire/transport/opening.h"

namespace copresence::wire {
namespace {

using asio::ip::tcp;

// Makes Asio write everything in one call. Asio's default is 64 KiB at a time.
constexpr auto kWhole = [](const asio::error_code& error, std::size_t) -> std::size_t {
  return error ? 0 : std::size_t{1} << 24;
};

void skip(std::array<asio::mutable_buffer, Connection::kMostBuffers>& buffers, std::size_t bytes) {
  for (asio::mutable_buffer& buffer : buffers) {
    const std::size_t part = std::min(bytes, buffer.size());
    buffer += part;
    bytes -= part;
  }
}

asio::error_code system_error(int number) {
  return {number, asio::error::get_system_category()};
}

asio::ip::address unmapped(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

}  // namespace

void Connection::connect(const std::vector<tcp::endpoint>& addresses, Done done) {
  is_client_ = true;
  asio::async_connect(socket_.asio(), addresses,
                      [this, done = std::move(done)](const asio::error_code& error, const tcp::endpoint&) {
                        if (!error) socket_.begin();
                        done(error);
                      });
}

void Connection::handshake(Done done) {
  if (!is_client_) return await_opening(kOpeningBytes, std::move(done));
  if (!encryption_) return finish(std::move(done), {});
  tls_ = tls::Session(*encryption_, *this);
  shake_hands(std::move(done));
}

void Connection::await_opening(std::size_t bytes, Done done) {
  socket_.wait_for_bytes(bytes);
  wait(Wait::wait_read, std::move(done), [this](Done then) { judge_opening(std::move(then)); });
}

void Connection::judge_opening(Done done) {
  std::array<std::uint8_t, kMostOfAClientHello> bytes{};
  const std::size_t arrived = socket_.peek(bytes);
  std::size_t needed = kOpeningBytes;
  Opening opening;
  if (arrived >= needed) {
    opening = recognise(std::span(bytes).first<kOpeningBytes>());
    if (opening.kind == Opening::Kind::kTls && encryption_) needed = opening.record_bytes;
  }
  if (arrived < needed) {
    if (socket_.has_peer_ended()) return finish(std::move(done), asio::error::eof);
    return await_opening(needed, std::move(done));
  }
  socket_.wait_for_bytes(1);
  if (opening.kind == Opening::Kind::kPlain) {
    return finish(std::move(done),
                  encryption_ ? make_error_code(TransportError::kPeerIsPlain) : asio::error_code());
  }
  if (!encryption_) return finish(std::move(done), TransportError::kPeerIsEncrypted);
  if (opening.kind == Opening::Kind::kBroken) return finish(std::move(done), TransportError::kBroken);
  tls_ = tls::Session(*encryption_, *this);
  shake_hands(std::move(done));
}

void Connection::shake_hands(Done done) {
  const Step step = step_of(tls_->handshake(), 0);
  if (peer_is_plain_) {
    tls_.reset();
    return finish(std::move(done), TransportError::kPeerIsPlain);
  }
  if (!step.wait) return finish(std::move(done), step.error);
  wait(*step.wait, std::move(done), [this](Done then) { shake_hands(std::move(then)); });
}

void Connection::read(std::initializer_list<asio::mutable_buffer> buffers, Done done) {
  Buffers all{};
  assert(buffers.size() <= all.size());
  std::copy(buffers.begin(), buffers.end(), all.begin());
  read_on(all, std::move(done));
}

void Connection::read_on(Buffers buffers, Done done) {
  while (asio::buffer_size(buffers) > 0) {
    const Step step = receive_some(buffers);
    if (step.error) return finish(std::move(done), step.error);
    if (step.wait) {
      return wait(*step.wait, std::move(done),
                  [this, buffers](Done then) { read_on(buffers, std::move(then)); });
    }
    skip(buffers, step.bytes);
  }
  finish(std::move(done), {});
}

void Connection::write(const std::vector<asio::const_buffer>& buffers, Done done) {
  if (tls_) {
    unwritten_ = buffers;
    next_unwritten_ = 0;
    return write_on(std::move(done));
  }
  asio::async_write(socket_.asio(), buffers, kWhole,
                    [done = std::move(done)](const asio::error_code& error, std::size_t) { done(error); });
}

void Connection::write_on(Done done) {
  for (; next_unwritten_ < unwritten_.size(); ++next_unwritten_) {
    asio::const_buffer& buffer = unwritten_[next_unwritten_];
    while (buffer.size() > 0) {
      const Step step = send_some(buffer);
      if (step.error) return finish(std::move(done), step.error);
      if (step.wait) {
        return wait(*step.wait, std::move(done), [this](Done then) { write_on(std::move(then)); });
      }
      buffer += step.bytes;
    }
  }
  finish(std::move(done), {});
}

Connection::Step Connection::receive_some(Buffers& buffers) {
  if (tls_) {
    const asio::mutable_buffer& buffer = buffers[0].size() > 0 ? buffers[0] : buffers[1];
    std::size_t got = 0;
    const tls::Outcome outcome = tls_->read({static_cast<std::uint8_t*>(buffer.data()), buffer.size()}, got);
    return step_of(outcome, got);
  }
  std::array<iovec, kMostBuffers> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = {buffers[i].data(), buffers[i].size()};
  const ssize_t got = socket_.receive(parts);
  if (got > 0) return {static_cast<std::size_t>(got), {}, {}};
  if (got == 0) return {0, {}, asio::error::eof};
  if (errno == EAGAIN || errno == EWOULDBLOCK) return {0, Wait::wait_read, {}};
  return {0, {}, system_error(errno)};
}

Connection::Step Connection::send_some(asio::const_buffer bytes) {
  const auto has_bytes = [](const asio::const_buffer& buffer) { return buffer.size() > 0; };
  const auto after = unwritten_.begin() + static_cast<std::ptrdiff_t>(next_unwritten_) + 1;
  more_follows_ =
      bytes.size() > tls::Session::kMostInRecord || std::any_of(after, unwritten_.end(), has_bytes);
  std::size_t taken = 0;
  const tls::Outcome outcome =
      tls_->write({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, taken);
  more_follows_ = false;
  return step_of(outcome, taken);
}

Connection::Step Connection::step_of(tls::Outcome outcome, std::size_t bytes) {
  switch (outcome) {
    case tls::Outcome::kDone:
      return {bytes, {}, {}};
    case tls::Outcome::kMustReceive:
      return {0, Wait::wait_read, {}};
    case tls::Outcome::kMustSend:
      return {0, Wait::wait_write, {}};
    case tls::Outcome::kEnded:
      return {0, {}, asio::error::eof};
    case tls::Outcome::kCarrierFailed:
      return {0, {}, system_error(carrier_error_)};
    case tls::Outcome::kWrongKey:
      return {0, {}, TransportError::kWrongKey};
    case tls::Outcome::kBroken:
      break;
  }
  return {0, {}, TransportError::kBroken};
}

std::ptrdiff_t Connection::receive(std::span<std::uint8_t> to) {
  // The answer of a server without a key stays unread, for the caller.
  std::array<std::uint8_t, 1> first;
  if (is_client_ && bytes_read() == 0 && socket_.peek(first) == 1 && !answers_in_tls(first[0])) {
    peer_is_plain_ = true;
    carrier_error_ = EPROTO;
    return -1;
  }
  std::array<iovec, 1> part = {{{to.data(), to.size()}}};
  const ssize_t got = socket_.receive(part);
  if (got < 0) carrier_error_ = errno;
  return got;
}

std::ptrdiff_t Connection::send(std::span<const std::uint8_t> from) {
  const ssize_t sent = socket_.send(from, more_follows_);
  if (sent < 0) carrier_error_ = errno;
  return sent;
}

template <class Continue>
void Connection::wait(Wait what, Done done, Continue go_on) {
  socket_.asio().async_wait(
      what, [done = std::move(done), go_on = std::move(go_on)](const asio::error_code& error) mutable {
        error ? done(error) : go_on(std::move(done));
      });
}

/// Posts `done`, which may start the next read. A direct call could make the stack grow.
void Connection::finish(Done done, const asio::error_code& error) {
  asio::post(socket_.asio().get_executor(), [done = std::move(done), error] { done(error); });
}

void Connection::end_writing() {
  if (tls_) tls_->end_writing();
  asio::error_code ignored;
  socket_.asio().shutdown(tcp::socket::shutdown_send, ignored);
}

void Connection::close() {
  asio::error_code ignored;
  socket_.asio().close(ignored);
}

std::string Connection::peer() const {
  asio::error_code ignored;
  const tcp::endpoint endpoint = socket_.asio().remote_endpoint(ignored);
  const asio::ip::address address = unmapped(endpoint.address());
  return fmt::format(fmt::runtime(address.is_v6() ? "[{}]:{}" : "{}:{}"), address.to_string(),
                     endpoint.port());
}

std::string Connection::peer_network() const {
  asio::error_code ignored;
  return network_of(socket_.asio().remote_endpoint(ignored).address());
}

std::string network_of(const asio::ip::address& address) {
  const asio::ip::address own = unmapped(address);
  if (own.is_v4()) return own.to_string();
  auto bytes = own.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return asio::ip::make_address_v6(bytes).to_string() + "/64";
}

}  // namespace copresence::wire
