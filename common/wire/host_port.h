#pragma once

// Parses HOST:PORT, for example 127.0.0.1:7001 or [::1]:7001. Thread: pure functions.

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::wire {

inline constexpr std::string_view kDefaultAddress = "127.0.0.1:7001";

struct HostPort {
  std::string host;  ///< Without the brackets of an IPv6 address.
  std::uint16_t port = 0;
  friend bool operator==(const HostPort&, const HostPort&) = default;
};

/// Fails with kInvalid. The message contains examples.
Result<HostPort> parse_host_port(std::string_view text);

}  // namespace copresence::wire
