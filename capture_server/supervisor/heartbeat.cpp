#include "capture_server/supervisor/heartbeat.h"

#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cassert>
#include <utility>

namespace copresence::server {
namespace {

constexpr int kFatalSignals[] = {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS};

// The report for the signal handler. The pointer is set before the handler is installed.
ChildReport* noted_in = nullptr;
struct sigaction actions_before[NSIG];

// Stores the first fatal signal in the report and passes it on to the former handler. The former
// handler is a sanitizer's or the default one, which ends the process.
void note_and_pass_on(int number, siginfo_t* info, void*) {
  int none = 0;
  if (noted_in->fatal_signal.compare_exchange_strong(none, number)) {
    char name[16] = {};
    ::prctl(PR_GET_NAME, name);
    noted_in->crashed_thread.set(name);
    const bool was_sent = info->si_code <= 0;
    noted_in->sender = was_sent ? info->si_pid : 0;
  }
  ::sigaction(number, &actions_before[number], nullptr);
  // A fault occurs again after the return. A sent signal does not, so it is raised again.
  if (info->si_code <= 0) ::raise(number);
}

}  // namespace

Heartbeat::Heartbeat(ChildReport& report, Predecessor predecessor)
    : report_(report), predecessor_(std::move(predecessor)), main_(pulse("main")) {
  main_.open();
}

Pulse Heartbeat::pulse(std::string_view name) {
  const std::size_t index = report_.threads_used.fetch_add(1);
  assert(index < ChildReport::kMostThreads);
  ChildReport::Thread& thread = report_.threads[index];
  thread.name.set(name);
  Pulse pulse(thread);
  pulse.rest();
  return pulse;
}

Heartbeat::Activity Heartbeat::doing(std::string_view what, std::string_view remedy) {
  report_.remedy.set(remedy);
  report_.activity.set(what);
  return Activity(report_);
}

void Heartbeat::note_crashes() {
  noted_in = &report_;
  // The handler needs its own stack, because the crash may be a stack overflow.
  static std::array<char, 64 * 1024> stack_of_handler;
  stack_t stack{};
  stack.ss_sp = stack_of_handler.data();
  stack.ss_size = stack_of_handler.size();
  ::sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_sigaction = note_and_pass_on;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (const int number : kFatalSignals) ::sigaction(number, &action, &actions_before[number]);
}

}  // namespace copresence::server
