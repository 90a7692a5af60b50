#pragma once

// Looks a host's name up in the background, so that whoever waits for it can give up at once. Private to this
// module: it shows Asio.
//
// The system's getaddrinfo() cannot be interrupted and may take half a minute where no name server answers.
// It runs on a thread of its own, which nobody joins: a lookup that was given up ends there by itself.
//
// Thread: make, use and destroy it on the thread that runs the io_context.

#include <asio.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace copresence::wire {

class NameLookup {
 public:
  using Done = std::function<void(const asio::error_code&, std::vector<asio::ip::tcp::endpoint>)>;

  /// Calls `done` from the io_context, which must outlive this, when the system knows the host's addresses or
  /// fails.
  NameLookup(asio::io_context& io, std::string host, std::uint16_t port, Done done);
  /// Gives up: `done` is not called any more.
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace copresence::wire
