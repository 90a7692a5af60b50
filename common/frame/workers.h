#pragma once

// How a room uses several cores without owning a thread: its caller lends it some. The threads themselves are
// made in a pipeline (common/flow/worker_pool.h).

#include <memory>
#include <type_traits>

namespace copresence {

/// A reference to something callable with a job's number; valid while that lives. Costs no allocation.
class JobRef {
 public:
  template <class Job, class = std::enable_if_t<!std::is_same_v<std::remove_cvref_t<Job>, JobRef>>>
  JobRef(Job&& job)  // NOLINT(google-explicit-constructor): a lambda is passed as it is
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(job)))),
        call_([](void* object, int number) {
          (*static_cast<std::remove_reference_t<Job>*>(object))(number);
        }) {}

  void operator()(int number) const { call_(object_, number); }

 private:
  void* object_;
  void (*call_)(void*, int);
};

/// Runs jobs side by side. Thread: run() from one thread at a time.
class Workers {
 public:
  virtual ~Workers() = default;

  /// Calls job(0) to job(jobs - 1), in any order and on any thread, and returns when all have ended. What a
  /// job writes no other may touch. Requires that no job throws or calls run() itself.
  virtual void run(int jobs, JobRef job) = 0;
};

/// The caller's own thread does everything, in order.
class NoWorkers : public Workers {
 public:
  void run(int jobs, JobRef job) override {
    for (int number = 0; number < jobs; ++number) job(number);
  }
};

}  // namespace copresence
