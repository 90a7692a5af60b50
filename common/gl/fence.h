#pragma once

// A mark in the command stream: tells when the graphics card has come that far.

#include <chrono>
#include <memory>

struct __GLsync;

namespace copresence::gl {

class Context;

struct FenceDeleter {
  void operator()(__GLsync* sync) const noexcept;
};

class Fence {
 public:
  /// Everything commanded so far lies before the mark. Sends it off.
  explicit Fence(Context& context);

  /// Waits until all of it is done; false after `timeout`. Zero just asks.
  bool wait(std::chrono::nanoseconds timeout) const;

 private:
  std::unique_ptr<__GLsync, FenceDeleter> sync_;
};

}  // namespace copresence::gl
