#pragma once

// Error handling. A Result<T> holds a value or an Error. An Error has a code for the program and
// one sentence for its user: what happened, where, and what to do.
//
// Errors report faults outside the program: in files, sockets, devices and received bytes. A
// violated precondition is a failed assert. Running out of memory ends the program.

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace copresence {

enum class ErrorCode {
  kInvalid,      ///< A value from a user or a file is not allowed.
  kNotFound,     ///< A file, a device or a camera does not exist.
  kCorrupt,      ///< Received or stored bytes violate their format.
  kUnsupported,  ///< The request is valid, but this build or device cannot do it.
  kUnavailable,  ///< A resource is busy or gone for now, such as a port or a peer.
  kRefused,      ///< The server rejects this client for good.
  kTimeout,      ///< No data arrived in time.
  kEndOfStream,  ///< The stream ended as it should.
};

struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string what;  ///< One sentence, without a trailing full stop or newline.
};

template <class T>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
};

/// Example: `return fail(ErrorCode::kCorrupt, fmt::format("{}: damaged at byte {}", path, at));`
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string what) {
  return tl::unexpected<Error>(Error{code, std::move(what)});
}

/// Passes an error on. Example: `if (!frame) return fail(frame.error());`
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace copresence
