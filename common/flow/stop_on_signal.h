#pragma once

// SIGINT and SIGTERM as a stop request, and SIGHUP as one to do something.

#include <functional>
#include <stop_token>
#include <thread>

namespace copresence::flow {

/// While one of these lives, SIGINT and SIGTERM do not end the process but request a stop. With `on_hangup` SIGHUP does not either
/// but calls that, on a thread of its own; a stop waits until it returns.
/// Requires to be made on the main thread before any other thread: new threads inherit the blocked signals.
class StopOnSignal {
 public:
  explicit StopOnSignal(std::function<void()> on_hangup = {});
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  std::stop_token token() const { return stop_.get_token(); }
  std::stop_source source() const { return stop_; }

  /// Asks for the same stop as a signal would. Any thread.
  void request_stop() { stop_.request_stop(); }

 private:
  std::stop_source stop_;
  std::jthread waiter_;
};

}  // namespace copresence::flow
