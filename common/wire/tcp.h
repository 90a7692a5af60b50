#pragma once

// What both ends want of a TCP socket. Not for other rooms: it shows Asio.

#include <netinet/tcp.h>
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

}  // namespace copresence::wire
