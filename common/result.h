#pragma once

// Error handling. A Result<T> holds a value or an Error. An Error has a code for the program and
// one sentence for its user: what happened, where, and what to do.
//
// Errors report faults outside the program: in files, sockets, devices and received bytes. A
// violated precondition is an assert. Running out of memory ends the program.

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace copresence {

enum class ErrorCode {
  kInvalid,      ///< a value from a user or a file is not allowed: a flag, a number, a name
  kNotFound,     ///< a file, a device or a camera does not exist
  kCorrupt,      ///< bytes violate their format
  kUnsupported,  ///< valid, but this build or this device cannot do it
  kUnavailable,  ///< busy or gone for now: a port in use, a peer that closed the connection
  kRefused,      ///< the server rejects this client for good
  kTimeout,      ///< nothing arrived in time
  kEndOfStream,  ///< the stream ended as it should
};

struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string what;  ///< one sentence, without a trailing full stop or newline
};

template <class T>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
};

/// `return fail(ErrorCode::kCorrupt, fmt::format("{}: record chain breaks at byte {}", path, at));`
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string what) {
  return tl::unexpected<Error>(Error{code, std::move(what)});
}

/// Passes an error on: `if (!frame) return fail(frame.error());`
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace copresence
