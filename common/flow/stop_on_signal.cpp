#include "common/flow/stop_on_signal.h"

#include <pthread.h>

#include <csignal>
#include <initializer_list>
#include <utility>

namespace copresence::flow {
namespace {

sigset_t set_of(std::initializer_list<int> signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) sigaddset(&set, signal);
  return set;
}

int next_of(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  return signal;
}

/// Ends a thread that waits in next_of() for `signal` and then checks its stop token.
void end(std::jthread& thread, int signal) {
  if (!thread.joinable()) return;
  thread.request_stop();
  pthread_kill(thread.native_handle(), signal);
  thread.join();
}

/// Makes SIGINT end the process, even if the process was started with SIGINT ignored.
void let_interrupts_kill() {
  std::signal(SIGINT, SIG_DFL);
  const sigset_t interrupt = set_of({SIGINT});
  pthread_sigmask(SIG_UNBLOCK, &interrupt, nullptr);
}

}  // namespace

StopOnSignal::StopOnSignal(std::function<void()> on_hangup) {
  sigset_t blocked = set_of({SIGINT, SIGTERM});
  if (on_hangup) sigaddset(&blocked, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
  stops_ = std::jthread([this](const std::stop_token& own_end) { wait_for_stop(own_end); });
  if (!on_hangup) return;
  // The callback may block, so it has a thread of its own. A stop request is not delayed.
  hangups_ = std::jthread([on_hangup = std::move(on_hangup)](const std::stop_token& own_end) {
    pthread_setname_np(pthread_self(), "hangups");
    const sigset_t hangup = set_of({SIGHUP});
    while (true) {
      next_of(hangup);
      if (own_end.stop_requested()) return;
      on_hangup();
    }
  });
}

StopOnSignal::~StopOnSignal() {
  end(hangups_, SIGHUP);
  end(stops_, SIGTERM);
  let_interrupts_kill();
}

void StopOnSignal::wait_for_stop(const std::stop_token& own_end) {
  pthread_setname_np(pthread_self(), "signals");
  sigset_t awaited = set_of({SIGINT, SIGTERM});
  while (true) {
    const int signal = next_of(awaited);
    if (own_end.stop_requested()) return;
    if (signal == SIGINT) {
      // Let SIGINT end the process before the stop request, since callbacks of the stop token may
      // block. Only this thread unblocks the signal, but the signal ends the whole process.
      sigdelset(&awaited, SIGINT);
      let_interrupts_kill();
    }
    stop_.request_stop();
  }
}

}  // namespace copresence::flow
