#include "common/flow/stop_on_signal.h"

#include <pthread.h>

#include <csignal>
#include <ctime>
#include <utility>

namespace copresence::flow {

StopOnSignal::StopOnSignal(std::function<void()> on_hangup) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  if (on_hangup) sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread([this, signals, on_hangup = std::move(on_hangup)](std::stop_token own_end) {
    pthread_setname_np(pthread_self(), "signals");
    constexpr timespec kLook{0, 100'000'000};  // how long the destructor may wait for this thread
    while (!own_end.stop_requested()) {
      const int signal = sigtimedwait(&signals, nullptr, &kLook);
      if (signal == SIGHUP) {
        on_hangup();
      } else if (signal > 0) {
        stop_.request_stop();
      }
    }
  });
}

}  // namespace copresence::flow
