#include "common/wire/transport/timed_socket.h"

#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace copresence::wire {
namespace {

using Clock = std::chrono::steady_clock;

// In bytes. A keyframe of one camera fits and can be written in one call.
constexpr int kSendBuffer = 256 * 1024;

std::chrono::nanoseconds nanoseconds_of(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

TimedSocket::TimedSocket(asio::ip::tcp::socket accepted) : socket_(std::move(accepted)) {
  asio::error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  begin();
}

void TimedSocket::begin() {
  // A socket works without these options, so failures are ignored.
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

ssize_t TimedSocket::receive(std::span<iovec> buffers) {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> notes;
  msghdr message{};
  message.msg_iov = buffers.data();
  message.msg_iovlen = buffers.size();
  message.msg_control = notes.data();
  message.msg_controllen = notes.size();
  ssize_t got = 0;
  do got = ::recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT);
  while (got < 0 && errno == EINTR);
  if (got > 0) {
    last_arrival_ = arrival_of(message);
    bytes_received_ += static_cast<std::uint64_t>(got);
  }
  return got;
}

ssize_t TimedSocket::send(std::span<const std::uint8_t> bytes, bool more_follows) {
  const int flags = MSG_DONTWAIT | MSG_NOSIGNAL | (more_follows ? MSG_MORE : 0);
  ssize_t sent = 0;
  do sent = ::send(socket_.native_handle(), bytes.data(), bytes.size(), flags);
  while (sent < 0 && errno == EINTR);
  return sent;
}

std::size_t TimedSocket::peek(std::span<std::uint8_t> bytes) {
  const ssize_t got = ::recv(socket_.native_handle(), bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  return got > 0 ? static_cast<std::size_t>(got) : 0;
}

void TimedSocket::wait_for_bytes(std::size_t bytes) {
  const int count = static_cast<int>(bytes);
  ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVLOWAT, &count, sizeof count);
}

bool TimedSocket::has_peer_ended() {
  pollfd watched{socket_.native_handle(), POLLRDHUP, 0};
  return ::poll(&watched, 1, 0) > 0;
}

Instant TimedSocket::arrival_of(msghdr& message) const {
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

int TimedSocket::unacknowledged_bytes() {
  int bytes = 0;
  return ::ioctl(socket_.native_handle(), SIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

}  // namespace copresence::wire
