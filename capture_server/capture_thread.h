#pragma once

// The only thread of a process that opens, reads and closes the source, and so the only one that
// calls OpenNI2. OpenNI2 (2.2.0.33) stores the ids of the threads that have called it. Later it
// probes them with pthread_kill(), which crashes if such a thread has ended. Therefore this thread
// is created once and lives until the process ends.
// Thread: any other thread may call begin() and run().

#include <pthread.h>

#include <functional>
#include <future>
#include <thread>
#include <utility>

#include "common/flow/bounded_queue.h"

namespace copresence::server {

class CaptureThread {
 public:
  CaptureThread() : thread_([this] { work(); }) { pthread_setname_np(thread_.native_handle(), "capture"); }
  /// Waits until the work in progress is done.
  ~CaptureThread() { waiting_.close(); }
  CaptureThread(const CaptureThread&) = delete;
  CaptureThread& operator=(const CaptureThread&) = delete;

  /// Queues `work` to run after all earlier work. The future becomes ready when it is done.
  std::future<void> begin(std::function<void()> work) {
    std::packaged_task<void()> task(std::move(work));
    auto done = task.get_future();
    waiting_.put(std::move(task));
    return done;
  }

  /// Runs `work` after all earlier work and waits until it is done.
  void run(std::function<void()> work) { begin(std::move(work)).get(); }

 private:
  void work() {
    while (auto task = waiting_.take()) (*task)();
  }

  flow::BoundedQueue<std::packaged_task<void()>> waiting_{4};
  std::jthread thread_;
};

}  // namespace copresence::server
