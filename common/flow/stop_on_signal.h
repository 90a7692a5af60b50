#pragma once

// SIGINT and SIGTERM as a stop request.

#include <stop_token>
#include <thread>

namespace copresence::flow {

/// While one of these lives, SIGINT and SIGTERM do not end the process but request a stop.
/// Requires to be made on the main thread before any other thread: new threads inherit the blocked signals.
class StopOnSignal {
 public:
  StopOnSignal();
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
