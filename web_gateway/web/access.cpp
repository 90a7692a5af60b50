#include "web_gateway/web/access.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace copresence::web {
namespace {

bool equal_without_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char left, unsigned char right) {
    return std::tolower(left) == std::tolower(right);
  });
}

/// Host and port of an origin such as https://room.example:8443.
std::string_view authority_of(std::string_view origin) {
  const std::size_t at = origin.find("://");
  return at == std::string_view::npos ? std::string_view() : origin.substr(at + 3);
}

std::string_view without_port(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

bool is_loopback_name(std::string_view host) {
  const std::string_view name = without_port(host);
  return equal_without_case(name, "localhost") || name == "127.0.0.1" || name == "[::1]";
}

}  // namespace

std::string_view Access::reason_to_refuse(std::string_view host, std::string_view origin) const {
  if (!origin.empty() && !equal_without_case(authority_of(origin), host)) {
    return "this room is shown only on its own page, not on other sites";
  }
  if (token.empty() && !is_open && !is_loopback_name(host)) {
    return "this gateway has no token, so it serves only its own machine, as 127.0.0.1 or localhost: start "
           "it with --token FILE, or with --open if everybody may watch";
  }
  return {};
}

bool Access::admits(std::string_view given_token) const {
  if (token.empty()) return true;
  unsigned difference = token.size() == given_token.size() ? 0 : 1;
  for (std::size_t i = 0; i < given_token.size(); ++i) {
    const unsigned char given = static_cast<unsigned char>(given_token[i]);
    difference |= static_cast<unsigned>(given ^ static_cast<unsigned char>(token[i % token.size()]));
  }
  return difference == 0;
}

}  // namespace copresence::web
