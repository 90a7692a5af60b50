#pragma once

// A fixed number of threads that share the jobs of one caller, who works along. Made in a pipeline, lent to
// rooms as Executor (common/executor.h).
//
// Idle threads sleep on a condition variable: no spinning, since capture servers want the same cores.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/executor.h"

namespace copresence::flow {

class WorkerPool : public Executor {
 public:
  /// `threads` >= 1 counts the caller: 1 makes none. The threads are called `name` in the system's lists (15
  /// characters at most).
  WorkerPool(int threads, const std::string& name);
  ~WorkerPool() override;
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int count() const override { return 1 + static_cast<int>(threads_.size()); }
  void run(int jobs, FunctionRef job) override;

 private:
  void serve(const std::stop_token& stop, int worker);
  void take_jobs(const FunctionRef& job, int jobs, int worker);

  std::mutex mutex_;
  std::condition_variable_any work_, idle_;
  std::uint64_t round_ = 0;           // counts calls of run(); guarded by mutex_, as are the three below
  const FunctionRef* job_ = nullptr;  // of the current round, null between rounds
  int jobs_ = 0;
  int working_ = 0;           // threads inside the current round
  std::atomic<int> next_{0};  // job to be taken next
  std::vector<std::jthread> threads_;
};

}  // namespace copresence::flow
