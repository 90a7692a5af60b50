#include "common/wire/transport/acceptor.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

namespace copresence::wire {
namespace {

using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptAgain{100};

}  // namespace

Result<void> Acceptor::open(const ListeningSocket& socket) {
  const int descriptor = ::dup(socket.descriptor());
  if (descriptor < 0) return fail(ErrorCode::kUnavailable, "cannot serve the port: too many open files");
  int domain = AF_INET;
  socklen_t size = sizeof domain;
  ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &domain, &size);
  asio::error_code error;
  acceptor_.assign(domain == AF_INET6 ? tcp::v6() : tcp::v4(), descriptor, error);
  if (error) {
    ::close(descriptor);
    return fail(ErrorCode::kUnavailable, fmt::format("cannot serve the port: {}", error.message()));
  }
  return {};
}

void Acceptor::run(Accepted accepted) {
  accepted_ = std::move(accepted);
  accept();
}

void Acceptor::close() {
  asio::error_code ignored;
  acceptor_.close(ignored);
  again_.cancel();
}

void Acceptor::accept() {
  acceptor_.async_accept([this](const asio::error_code& error, tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    if (error) {
      // Most likely, all file descriptors are in use. Try again later, when other connections have
      // ended.
      again_.expires_after(kAcceptAgain);
      return again_.async_wait([this](const asio::error_code& cancelled) {
        if (!cancelled) accept();
      });
    }
    accepted_(std::make_unique<Connection>(std::move(socket), encryption_));
    accept();
  });
}

}  // namespace copresence::wire
