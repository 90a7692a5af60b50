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

/// Ends a thread that waits in next_of() for `signal` among others, and looks at its stop token then.
void end(std::jthread& thread, int signal) {
  if (!thread.joinable()) return;
  thread.request_stop();
  pthread_kill(thread.native_handle(), signal);
  thread.join();
}

/// From now on SIGINT ends the process, even where it was started with SIGINT ignored.
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
  // A thread of its own: whatever the callback waits for, a stop gets through.
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
  // Nobody turns it into a stop any more.
  let_interrupts_kill();
}

void StopOnSignal::wait_for_stop(const std::stop_token& own_end) {
  pthread_setname_np(pthread_self(), "signals");
  sigset_t awaited = set_of({SIGINT, SIGTERM});
  while (true) {
    const int signal = next_of(awaited);
    if (own_end.stop_requested()) return;
    if (signal == SIGINT) {
      // Before the stop is requested, since whoever is told of it may block. This thread alone lets the
      // signal in; it ends the whole process.
      sigdelset(&awaited, SIGINT);
      let_interrupts_kill();
    }
    stop_.request_stop();
  }
}

}  // namespace copresence::flow
