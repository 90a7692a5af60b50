#include "web_gateway/web/responses.h"

#include "web_gateway/page/page_files.h"

namespace copresence::web {
namespace {

std::string_view value_of(const Request& request, http::field name) {
  const auto value = request[name];
  return {value.data(), value.size()};
}

std::string_view path_of(const Request& request) {
  const std::string_view target(request.target().data(), request.target().size());
  return target.substr(0, target.find('?'));
}

/// A response without a body. The caller sets its body and its length.
Response response_to(const Request& request, http::status status) {
  Response response{status, request.version()};
  set_security_headers(response.base());
  response.keep_alive(request.keep_alive());
  return response;
}

}  // namespace

void set_security_headers(http::fields& fields) {
  fields.set("Content-Security-Policy",
             "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
             "connect-src 'self'; style-src 'self'; img-src 'self' data: blob:; manifest-src 'self'; "
             "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  fields.set("Cross-Origin-Opener-Policy", "same-origin");
  fields.set("Cross-Origin-Embedder-Policy", "require-corp");
  fields.set("Cross-Origin-Resource-Policy", "same-origin");
  fields.set("X-Content-Type-Options", "nosniff");
  fields.set("Referrer-Policy", "no-referrer");
  fields.set("Permissions-Policy",
             "accelerometer=(self), camera=(), fullscreen=(self), geolocation=(), gyroscope=(self), "
             "microphone=(), xr-spatial-tracking=(self)");
  // Browsers keep a copy and ask each time whether it is still the newest.
  fields.set(http::field::cache_control, "no-cache");
}

std::string_view reason_to_refuse(const Request& request, const Access& access) {
  return access.reason_to_refuse(value_of(request, http::field::host),
                                 value_of(request, http::field::origin));
}

Response respond_with(http::status status, std::string_view sentence, const Request& request) {
  Response response = response_to(request, status);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.content_length(sentence.size());
  if (request.method() != http::verb::head) {
    response.body() = {reinterpret_cast<const std::uint8_t*>(sentence.data()), sentence.size()};
  }
  return response;
}

Response respond(const Request& request, const Access& access) {
  const std::string_view refused = reason_to_refuse(request, access);
  if (!refused.empty()) return respond_with(http::status::forbidden, refused, request);
  const bool is_head = request.method() == http::verb::head;
  if (request.method() != http::verb::get && !is_head) {
    Response response =
        respond_with(http::status::method_not_allowed, "only GET and HEAD work here", request);
    response.set(http::field::allow, "GET, HEAD");
    return response;
  }
  if (path_of(request) == kRoomPath) {
    return respond_with(http::status::upgrade_required, "the room needs a WebSocket connection", request);
  }
  const page::File* const file = page::find(path_of(request));
  if (!file) return respond_with(http::status::not_found, "there is no such page", request);
  if (value_of(request, http::field::if_none_match) == file->etag) {
    Response response = response_to(request, http::status::not_modified);
    response.set(http::field::etag, {file->etag.data(), file->etag.size()});
    return response;
  }
  const bool compressed =
      !file->gzip.empty() &&
      value_of(request, http::field::accept_encoding).find("gzip") != std::string_view::npos;
  const auto bytes = compressed ? file->gzip : file->bytes;
  Response response = response_to(request, http::status::ok);
  response.set(http::field::content_type, {file->content_type.data(), file->content_type.size()});
  response.set(http::field::etag, {file->etag.data(), file->etag.size()});
  response.set(http::field::vary, "Accept-Encoding");
  if (compressed) response.set(http::field::content_encoding, "gzip");
  response.content_length(bytes.size());
  if (!is_head) response.body() = {bytes.data(), bytes.size()};
  return response;
}

}  // namespace copresence::web
