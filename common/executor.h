#pragma once

// How a room uses several cores without owning a thread: its caller lends it some. The threads themselves are
// made in a pipeline (common/flow/worker_pool.h).

#include <memory>
#include <type_traits>

namespace copresence {

/// A reference to something callable with a job's and a worker's number; valid while that lives. Costs no
/// allocation.
class FunctionRef {
 public:
  template <class Job, class = std::enable_if_t<!std::is_same_v<std::remove_cvref_t<Job>, FunctionRef>>>
  FunctionRef(Job&& job)  // NOLINT(google-explicit-constructor): a lambda is passed as it is
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(job)))), call_(&call<Job>) {}

  void operator()(int number, int worker) const { call_(object_, number, worker); }

 private:
  template <class Job>
  static void call(void* object, int number, int worker) {
    (*static_cast<std::remove_reference_t<Job>*>(object))(number, worker);
  }

  void* object_;
  void (*call_)(void*, int, int);
};

/// Runs jobs side by side. Thread: run() from one thread at a time.
class Executor {
 public:
  virtual ~Executor() = default;

  /// How many jobs may run at a time, the caller's own thread included; >= 1.
  virtual int count() const = 0;

  /// Calls job(0, worker) to job(jobs - 1, worker), in any order and on any thread, and returns when all have
  /// ended. Jobs that run at a time have different workers, 0 to count() - 1: scratch memory goes by worker,
  /// results go by job. Requires that no job throws or calls run() itself.
  virtual void run(int jobs, FunctionRef job) = 0;
};

/// The caller's own thread does everything, in order.
class InlineExecutor : public Executor {
 public:
  int count() const override { return 1; }
  void run(int jobs, FunctionRef job) override {
    for (int number = 0; number < jobs; ++number) job(number, 0);
  }
};

}  // namespace copresence
