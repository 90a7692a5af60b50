#include "common/wire/transport/connection.h"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace copresence::wire {
namespace {

using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

// In bytes. A keyframe of one camera fits and can be written in one call.
constexpr int kSendBuffer = 256 * 1024;

// Makes Asio write everything in one call. Asio's default is 64 KiB at a time.
constexpr auto kWhole = [](const asio::error_code& error, std::size_t) -> std::size_t {
  return error ? 0 : std::size_t{1} << 24;
};

std::chrono::nanoseconds nanoseconds_of(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void skip(std::array<asio::mutable_buffer, Connection::kMostBuffers>& buffers, std::size_t bytes) {
  for (asio::mutable_buffer& buffer : buffers) {
    const std::size_t part = std::min(bytes, buffer.size());
    buffer += part;
    bytes -= part;
  }
}

asio::ip::address unmapped(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

}  // namespace

Connection::Connection(tcp::socket accepted) : socket_(std::move(accepted)) {
  asio::error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  begin();
}

void Connection::connect(const std::vector<tcp::endpoint>& addresses, Done done) {
  asio::async_connect(socket_, addresses,
                      [this, done = std::move(done)](const asio::error_code& error, const tcp::endpoint&) {
                        if (!error) begin();
                        done(error);
                      });
}

/// Sets options that send small messages at once and detect a vanished peer within about 10 s. A
/// socket works without these options, so failures are ignored.
void Connection::begin() {
  const auto set = [this](int level, int name, int value) {
    ::setsockopt(socket_.native_handle(), level, name, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 10000);
  set(SOL_SOCKET, SO_TIMESTAMPNS, 1);
  asio::error_code ignored;
  socket_.non_blocking(true, ignored);
  // Lower bound of the arrival times: no byte can have arrived earlier.
  last_arrival_ = Clock::now();
}

void Connection::read(std::initializer_list<asio::mutable_buffer> buffers, Done done) {
  Buffers all{};
  assert(buffers.size() <= all.size());
  std::copy(buffers.begin(), buffers.end(), all.begin());
  read_on(all, std::move(done));
}

void Connection::read_on(Buffers buffers, Done done) {
  // Post `done`, which starts the next read. A direct call could make the stack grow.
  const auto finish = [this](Done what, const asio::error_code& error) {
    asio::post(socket_.get_executor(), [what = std::move(what), error] { what(error); });
  };
  while (asio::buffer_size(buffers) > 0) {
    std::array<iovec, kMostBuffers> parts;
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = {buffers[i].data(), buffers[i].size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> notes;
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    message.msg_control = notes.data();
    message.msg_controllen = notes.size();
    const ssize_t got = ::recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT);
    if (got > 0) {
      last_arrival_ = arrival_of(message);
      bytes_read_ += static_cast<std::uint64_t>(got);
      skip(buffers, static_cast<std::size_t>(got));
    } else if (got == 0) {
      return finish(std::move(done), asio::error::eof);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return socket_.async_wait(asio::socket_base::wait_read, [this, buffers, done = std::move(done)](
                                                                  const asio::error_code& error) mutable {
        if (error) return done(error);
        read_on(buffers, std::move(done));
      });
    } else if (errno != EINTR) {
      return finish(std::move(done), {errno, asio::error::get_system_category()});
    }
  }
  finish(std::move(done), {});
}

Instant Connection::arrival_of(msghdr& message) const {
  const Instant now = Clock::now();
  for (cmsghdr* note = CMSG_FIRSTHDR(&message); note; note = CMSG_NXTHDR(&message, note)) {
    if (note->cmsg_level != SOL_SOCKET || note->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec queued, wall_now;
    std::memcpy(&queued, CMSG_DATA(note), sizeof queued);
    ::clock_gettime(CLOCK_REALTIME, &wall_now);
    // The kernel's times are wall-clock times. The clamp bounds the error if that clock is set.
    const Instant arrived = now - (nanoseconds_of(wall_now) - nanoseconds_of(queued));
    return std::clamp(arrived, last_arrival_, now);
  }
  return now;
}

void Connection::write(const std::vector<asio::const_buffer>& buffers, Done done) {
  asio::async_write(socket_, buffers, kWhole,
                    [done = std::move(done)](const asio::error_code& error, std::size_t) { done(error); });
}

void Connection::end_writing() {
  asio::error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_send, ignored);
}

void Connection::close() {
  asio::error_code ignored;
  socket_.close(ignored);
}

int Connection::unacknowledged_bytes() {
  int bytes = 0;
  return ::ioctl(socket_.native_handle(), SIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

std::string Connection::peer() const {
  asio::error_code ignored;
  const tcp::endpoint endpoint = socket_.remote_endpoint(ignored);
  const asio::ip::address address = unmapped(endpoint.address());
  return fmt::format(fmt::runtime(address.is_v6() ? "[{}]:{}" : "{}:{}"), address.to_string(),
                     endpoint.port());
}

std::string Connection::peer_network() const {
  asio::error_code ignored;
  return network_of(socket_.remote_endpoint(ignored).address());
}

std::string network_of(const asio::ip::address& address) {
  const asio::ip::address own = unmapped(address);
  if (own.is_v4()) return own.to_string();
  auto bytes = own.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return asio::ip::make_address_v6(bytes).to_string() + "/64";
}

}  // namespace copresence::wire
