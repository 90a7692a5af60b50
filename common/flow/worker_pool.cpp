#include "common/flow/worker_pool.h"

#include <pthread.h>

#include <cassert>

namespace copresence::flow {

WorkerPool::WorkerPool(int threads, const std::string& name) {
  assert(threads >= 1);
  for (int i = 1; i < threads; ++i) {
    threads_.emplace_back([this, i](const std::stop_token& stop) { serve(stop, i); });
    pthread_setname_np(threads_.back().native_handle(), name.substr(0, 15).c_str());
  }
}

WorkerPool::~WorkerPool() {
  for (auto& thread : threads_) thread.request_stop();
}

void WorkerPool::run(int jobs, FunctionRef job) {
  if (jobs > 1 && !threads_.empty()) {
    {
      std::lock_guard lock(mutex_);
      assert(job_ == nullptr);
      ++round_;
      job_ = &job;
      jobs_ = jobs;
      next_.store(0, std::memory_order_relaxed);
    }
    work_.notify_all();
    take_jobs(job, jobs, 0);
    // Threads that have not woken up yet will find no job. Wait for the others to finish.
    std::unique_lock lock(mutex_);
    job_ = nullptr;
    idle_.wait(lock, [this] { return working_ == 0; });
  } else {
    for (int number = 0; number < jobs; ++number) job(number, 0);
  }
}

void WorkerPool::serve(const std::stop_token& stop, int worker) {
  std::uint64_t served = 0;
  std::unique_lock lock(mutex_);
  while (work_.wait(lock, stop, [&] { return job_ != nullptr && round_ != served; })) {
    served = round_;
    const FunctionRef job = *job_;
    const int jobs = jobs_;
    ++working_;
    lock.unlock();
    take_jobs(job, jobs, worker);
    lock.lock();
    if (--working_ == 0) idle_.notify_one();
  }
}

void WorkerPool::take_jobs(const FunctionRef& job, int jobs, int worker) {
  for (int number = next_.fetch_add(1, std::memory_order_relaxed); number < jobs;
       number = next_.fetch_add(1, std::memory_order_relaxed)) {
    job(number, worker);
  }
}

}  // namespace copresence::flow
