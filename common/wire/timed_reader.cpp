#include "common/wire/timed_reader.h"

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

using Clock = std::chrono::steady_clock;

std::chrono::nanoseconds nanoseconds_of(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

void TimedReader::start() {
  const int on = 1;
  ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  last_arrival_ = Clock::now();
}

void TimedReader::read(std::initializer_list<asio::mutable_buffer> buffers, Done done) {
  assert(!done_ && buffers.size() <= buffers_.size());
  buffers_ = {};
  std::copy(buffers.begin(), buffers.end(), buffers_.begin());
  done_ = std::move(done);
  go_on();
}

void TimedReader::go_on() {
  while (asio::buffer_size(buffers_) > 0) {
    std::array<iovec, kMostBuffers> parts;
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = {buffers_[i].data(), buffers_[i].size()};
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
      skip(static_cast<std::size_t>(got));
    } else if (got == 0) {
      return finish(asio::error::eof);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return socket_.async_wait(asio::socket_base::wait_read, [this](const asio::error_code& error) {
        if (error) return finish(error);
        go_on();
      });
    } else if (errno != EINTR) {
      return finish({errno, asio::error::get_system_category()});
    }
  }
  finish({});
}

void TimedReader::finish(const asio::error_code& error) {
  // Posted, since `done` begins the next read: a peer that always has bytes ready would grow the stack.
  asio::post(socket_.get_executor(), [this, error] { std::exchange(done_, nullptr)(error); });
}

void TimedReader::skip(std::size_t bytes) {
  for (asio::mutable_buffer& buffer : buffers_) {
    const std::size_t part = std::min(bytes, buffer.size());
    buffer += part;
    bytes -= part;
  }
}

Instant TimedReader::arrival_of(msghdr& message) const {
  const Instant now = Clock::now();
  for (cmsghdr* note = CMSG_FIRSTHDR(&message); note; note = CMSG_NXTHDR(&message, note)) {
    if (note->cmsg_level != SOL_SOCKET || note->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec queued, wall_now;
    std::memcpy(&queued, CMSG_DATA(note), sizeof queued);
    ::clock_gettime(CLOCK_REALTIME, &wall_now);
    // The kernel's times are wall-clock times. Should the wall clock be set meanwhile, the limits hold the
    // error.
    const Instant arrived = now - (nanoseconds_of(wall_now) - nanoseconds_of(queued));
    return std::clamp(arrived, last_arrival_, now);
  }
  return now;
}

}  // namespace copresence::wire
