#pragma once

// Turns SIGINT and SIGTERM into a stop request, and SIGHUP into a callback.

#include <functional>
#include <stop_token>
#include <thread>

namespace copresence::flow {

/// While one of these lives, SIGTERM and the first SIGINT request a stop instead of ending the process. The
/// second SIGINT (Ctrl-C) ends the process at once, whatever its threads are doing; its exit status says so.
/// A second SIGTERM changes nothing: service managers send it to each process of a group, and a parent hands
/// it on.
///
/// With `on_hangup`, SIGHUP calls that on a thread of its own instead of ending the process. Hang-ups that
/// come meanwhile cause one more call. The destructor waits until the call returns.
///
/// Requires to be made and destroyed on the main thread, before any other thread is made: new threads inherit
/// the blocked signals. One at a time.
class StopOnSignal {
 public:
  explicit StopOnSignal(std::function<void()> on_hangup = {});
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  std::stop_token token() const { return stop_.get_token(); }
  std::stop_source source() const { return stop_; }

  /// Requests the same stop as a signal would. Any thread.
  void request_stop() { stop_.request_stop(); }

 private:
  void wait_for_stop(const std::stop_token& own_end);

  std::stop_source stop_;
  std::jthread stops_, hangups_;
};

}  // namespace copresence::flow
