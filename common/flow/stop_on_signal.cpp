#include "common/flow/stop_on_signal.h"

#include <pthread.h>

#include <csignal>
#include <ctime>

namespace copresence::flow {

StopOnSignal::StopOnSignal() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread([this, signals](std::stop_token own_end) {
    pthread_setname_np(pthread_self(), "signals");
    constexpr timespec kLook{0, 100'000'000};  // how long the destructor may wait for this thread
    while (!own_end.stop_requested()) {
      if (sigtimedwait(&signals, nullptr, &kLook) > 0) stop_.request_stop();
    }
  });
}

}  // namespace copresence::flow
