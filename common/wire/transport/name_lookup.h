#pragma once

// Looks up a host name in the background, so that the caller can cancel it at once. The system's
// getaddrinfo() cannot be interrupted and may take half a minute without a name server. So the
// lookup runs on a detached thread, which ends by itself. Thread: the thread that runs the
// io_context.

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

  /// Starts the lookup. `io` must outlive this object and calls `done` with addresses or an error.
  NameLookup(asio::io_context& io, std::string host, std::uint16_t port, Done done);
  /// Cancels the lookup: `done` will not be called.
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace copresence::wire
