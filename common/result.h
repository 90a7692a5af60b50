#pragma once

// How anything here fails: a Result<T> holds a value or an Error, and an Error is a code for the program and
// one sentence for the person in front of it: what went wrong, where, and what to do about it.
//
// Errors are for the world (files, sockets, devices, other people's bytes). A broken promise of the caller is
// an assert. Out of memory ends the program.

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace copresence {

enum class ErrorCode {
  kInvalid,      ///< a value from a person or a file that makes no sense: a flag, a number, a name
  kNotFound,     ///< a file, a device or a camera that is not there
  kCorrupt,      ///< bytes that do not say what they claim to
  kUnsupported,  ///< understood, but not something this build or this device can do
  kUnavailable,  ///< busy or gone for now: a port in use, a peer that hung up
  kRefused,      ///< the other side said no, for good
  kTimeout,      ///< nothing came within the time given
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

/// Hands an error on: `if (!frame) return fail(frame.error());`
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace copresence
