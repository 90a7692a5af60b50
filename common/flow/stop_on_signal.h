#pragma once

// Turns SIGINT and SIGTERM into a stop request, and SIGHUP into a callback.

#include <functional>
#include <stop_token>
#include <thread>

namespace copresence::flow {

/// While an object of this class exists, SIGTERM and the first SIGINT (Ctrl-C) request a stop
/// instead of ending the process. The second SIGINT ends the process at once; its exit status shows
/// the signal. A second SIGTERM has no effect: service managers send it to each process of a group,
/// and our parent process forwards it.
///
/// If `on_hangup` is given, SIGHUP calls it on a separate thread instead of ending the process.
/// If signals arrive during a call, the function is called once more afterwards. The destructor
/// waits until the call returns.
///
/// Create and destroy the object on the main thread, before any other thread exists, since new
/// threads inherit the blocked signals. Only one object may exist at a time.
class StopOnSignal {
 public:
  explicit StopOnSignal(std::function<void()> on_hangup = {});
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  std::stop_token token() const { return stop_.get_token(); }
  std::stop_source source() const { return stop_; }

  /// Requests a stop, as a signal does. Any thread may call this function.
  void request_stop() { stop_.request_stop(); }

 private:
  void wait_for_stop(const std::stop_token& own_end);

  std::stop_source stop_;
  std::jthread stops_, hangups_;
};

}  // namespace copresence::flow
