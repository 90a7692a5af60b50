#pragma once

// Options and state of TCP sockets that both ends use. Not for other modules: it shows Asio.

#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <asio.hpp>

namespace copresence::wire {

/// Reads or writes as much as there is in one call; Asio's own default is 64 KiB at a time.
inline constexpr auto kWhole = [](const asio::error_code& error, std::size_t) -> std::size_t {
  return error ? 0 : std::size_t{1} << 24;
};

/// Small messages leave at once, and a peer that vanished without a word is noticed within about ten seconds.
/// Failures are ignored: a socket that refuses an option still works.
inline void tune(asio::ip::tcp::socket& socket) {
  const auto set = [&socket](int level, int name, int value) {
    ::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 10000);
}

/// Bytes that were written to the socket and that the other end's kernel has not acknowledged.
inline int unacknowledged_bytes(asio::ip::tcp::socket& socket) {
  int bytes = 0;
  return ::ioctl(socket.native_handle(), SIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

}  // namespace copresence::wire
