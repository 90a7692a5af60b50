#pragma once

// Interface through which a module runs jobs on several cores without owning threads. The pipelines
// own the threads (common/flow/worker_pool.h).

#include <memory>
#include <type_traits>

namespace copresence {

/// Reference to a function object that takes the number of a job and of a worker. It allocates no
/// memory. The function object must outlive the reference.
class FunctionRef {
 public:
  template <class Job, class = std::enable_if_t<!std::is_same_v<std::remove_cvref_t<Job>, FunctionRef>>>
  FunctionRef(Job&& job)  // NOLINT(google-explicit-constructor): callers pass a lambda
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

/// Runs jobs in parallel. Thread: run() from one thread at a time.
class Executor {
 public:
  virtual ~Executor() = default;

  /// The largest number of jobs that run at the same time, at least 1. This number includes the
  /// caller's thread.
  virtual int count() const = 0;

  /// Calls job(0, worker) to job(jobs - 1, worker) in any order, on any threads. Returns after all
  /// jobs have returned. Jobs that run at the same time get different worker numbers below count().
  /// Index scratch memory by worker and results by job. Requires that no job throws or calls run().
  virtual void run(int jobs, FunctionRef job) = 0;
};

/// Runs all jobs on the calling thread, in order.
class InlineExecutor : public Executor {
 public:
  int count() const override { return 1; }
  void run(int jobs, FunctionRef job) override {
    for (int number = 0; number < jobs; ++number) job(number, 0);
  }
};

}  // namespace copresence
