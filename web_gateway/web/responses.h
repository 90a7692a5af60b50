#pragma once

// Makes the answers to HTTP requests: the page's files, and one sentence for everything else.
// Private to this module. Thread: pure functions.

#include <boost/beast/http.hpp>
#include <cstdint>
#include <string_view>

#include "web_gateway/web/access.h"

namespace copresence::web {

namespace http = boost::beast::http;

using Request = http::request<http::empty_body>;
/// The body is a view of bytes that live as long as the program.
using Response = http::response<http::span_body<const std::uint8_t>>;

/// The path at which the page opens its WebSocket.
inline constexpr std::string_view kRoomPath = "/room";

/// Sets the headers of every response. They allow the page no requests to other servers. They also
/// isolate the page from other sites, which WebAssembly threads need.
void set_security_headers(http::fields& fields);

/// Answers with a file of the page, or with an error.
Response respond(const Request& request, const Access& access);
/// Answers with one sentence, which must live as long as the program.
Response respond_with(http::status status, std::string_view sentence, const Request& request);

/// Returns the reason why these headers are refused, or an empty text.
std::string_view reason_to_refuse(const Request& request, const Access& access);

}  // namespace copresence::web
