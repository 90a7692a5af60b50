#pragma once

// Decides which requests a web server answers. Static files are public; the room's data needs the
// token. Two rules protect viewers on the gateway's own machine from other sites' scripts:
//
// Origin: a browser names the site of the script that makes a request. Only the page that this
// server served itself may make requests (RFC 6454; RFC 6455, section 10.2).
// Host: without a token, the request must address this machine as a loopback name. Otherwise a
// foreign site whose name resolves to 127.0.0.1 would count as the same origin (DNS rebinding).
// Thread: pure functions and values.

#include <string>
#include <string_view>

namespace copresence::web {

struct Access {
  std::string token;     ///< Empty if no token is needed.
  bool is_open = false;  ///< True to serve every host name without a token.

  /// Returns the reason why a request with these headers is refused, or an empty text. A header
  /// that is missing is empty.
  std::string_view reason_to_refuse(std::string_view host, std::string_view origin) const;
  /// Compares in a time that does not depend on the texts' contents.
  bool admits(std::string_view given_token) const;
};

}  // namespace copresence::web
