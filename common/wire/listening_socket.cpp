#include "common/wire/listening_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <asio.hpp>
#include <utility>

#include "common/wire/host_port.h"

namespace copresence::wire {
namespace {

using asio::ip::tcp;

// Limit of connections that wait in the kernel to be accepted. If it is reached, the kernel drops
// connections, and a client tries again only after a second.
constexpr int kWaiting = 512;

int option(int descriptor, int name) {
  int value = 0;
  socklen_t size = sizeof value;
  return ::getsockopt(descriptor, SOL_SOCKET, name, &value, &size) == 0 ? value : -1;
}

tcp::endpoint endpoint_of(int descriptor) {
  tcp::endpoint endpoint;
  socklen_t size = static_cast<socklen_t>(endpoint.capacity());
  if (::getsockname(descriptor, endpoint.data(), &size) == 0) endpoint.resize(size);
  return endpoint;
}

}  // namespace

Result<ListeningSocket> ListeningSocket::adopt(int descriptor) {
  const int domain = option(descriptor, SO_DOMAIN);
  if (option(descriptor, SO_ACCEPTCONN) != 1 || (domain != AF_INET && domain != AF_INET6)) {
    return fail(ErrorCode::kInvalid, fmt::format("descriptor {} is not a listening TCP socket", descriptor));
  }
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  return ListeningSocket(descriptor);
}

ListeningSocket::ListeningSocket(ListeningSocket&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

ListeningSocket& ListeningSocket::operator=(ListeningSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

ListeningSocket::~ListeningSocket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string ListeningSocket::address() const {
  const tcp::endpoint endpoint = endpoint_of(descriptor_);
  const std::string host = endpoint.address().to_string();
  return fmt::format(fmt::runtime(endpoint.address().is_v6() ? "[{}]:{}" : "{}:{}"), host, endpoint.port());
}

bool ListeningSocket::is_loopback() const {
  return endpoint_of(descriptor_).address().is_loopback();
}

Result<ListeningSocket> listen(const std::string& host_port, Reach reach) {
  const auto address = parse_host_port(host_port);
  if (!address) return fail(address.error());

  asio::io_context io;
  asio::error_code error;
  const auto found =
      tcp::resolver(io).resolve(address->host, std::to_string(address->port),
                                tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error || found.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: this machine has no address \"{}\" ({})", host_port,
                                                  address->host, error.message()));
  }
  const auto is_loopback = [](const auto& entry) { return entry.endpoint().address().is_loopback(); };
  if (reach == Reach::kThisMachine && !std::all_of(found.begin(), found.end(), is_loopback)) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "{} can be reached from other machines: encrypt the stream with --key FILE (capture_server "
            "--make-key FILE makes one), listen on {}, or add --insecure if everybody on that network may "
            "watch",
            host_port, kDefaultAddress));
  }
  tcp::acceptor acceptor(io);
  // The name localhost may mean 127.0.0.1 and ::1, of which one may be disabled.
  for (const tcp::endpoint endpoint : found) {
    acceptor = tcp::acceptor(io);
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(kWaiting, error);
    if (!error || error == asio::error::address_in_use) break;
  }
  if (error == asio::error::address_in_use) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{} is in use by another program: stop it, or choose another port with --listen",
                            host_port));
  }
  if (error) {
    return fail(ErrorCode::kUnavailable, fmt::format("cannot listen on {}: {}", host_port, error.message()));
  }
  const int descriptor = ::dup(acceptor.native_handle());
  if (descriptor < 0) return fail(ErrorCode::kUnavailable, "cannot listen: too many open files");
  return ListeningSocket::adopt(descriptor);
}

}  // namespace copresence::wire
