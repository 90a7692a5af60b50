#include "common/wire/host_port.h"

#include <fmt/format.h>

#include <charconv>

#include "common/text/excerpt.h"

namespace copresence::wire {

Result<HostPort> parse_host_port(std::string_view text) {
  const auto invalid = [text] {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("\"{}\" is not an address: write HOST:PORT, for instance 127.0.0.1:7001 or [::1]:7001",
                    text::sanitise(text, 100)));
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return invalid();
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return invalid();  // An IPv6 address without brackets is ambiguous.
  }
  HostPort out{std::string(host), 0};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), out.port);
  const bool number = error == std::errc{} && end == port.data() + port.size();
  if (!number || host.empty() || !text::is_printable(host)) return invalid();
  return out;
}

}  // namespace copresence::wire
