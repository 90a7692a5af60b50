#pragma once

// A fixed number of threads that run the jobs of one caller. The calling thread runs jobs, too.
// Pipelines create the pool, and modules use it as an Executor (common/executor.h).
//
// Idle threads sleep instead of spinning, since capture servers need the same cores.

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
  /// Requires threads >= 1. The number includes the caller, so 1 creates no thread. The system
  /// shows the threads under `name`, cut to 15 characters.
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
  // mutex_ guards these. A round is one call of run(). Between two rounds job_ is null.
  std::uint64_t round_ = 0;
  const FunctionRef* job_ = nullptr;
  int jobs_ = 0;
  int working_ = 0;  // Number of threads that run jobs now.

  std::atomic<int> next_{0};  // Number of the next job.
  std::vector<std::jthread> threads_;
};

}  // namespace copresence::flow
