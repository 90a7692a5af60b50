#include "common/flow/worker_pool.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <vector>

namespace copresence::flow {
namespace {

TEST(WorkerPool, RunsEveryJobOnce) {
  for (int threads : {1, 2, 5}) {
    WorkerPool pool(threads, "test");
    for (int jobs : {0, 1, 2, 3, 100}) {
      std::vector<int> runs(jobs);
      pool.run(jobs, [&](int job, int) { ++runs[job]; });
      EXPECT_EQ(runs, std::vector<int>(jobs, 1)) << threads << " threads";
    }
  }
}

TEST(WorkerPool, HasEverythingDoneWhenRunReturns) {
  WorkerPool pool(4, "test");
  std::vector<long> sums(64);
  for (int round = 1; round <= 300; ++round) {
    pool.run(int(sums.size()), [&](int job, int) { sums[job] += round; });
  }
  for (long sum : sums) EXPECT_EQ(sum, 300L * 301 / 2);
}

TEST(WorkerPool, SharesTheJobsAmongThreads) {
  WorkerPool pool(2, "test");
  // Job 0 ends only when job 1 has begun: one thread alone would never get there.
  std::atomic<bool> second_began = false;
  pool.run(2, [&](int job, int) {
    if (job == 1) second_began = true;
    while (!second_began) std::this_thread::yield();
  });
  EXPECT_TRUE(second_began);
}

TEST(WorkerPool, NeverGivesTwoJobsAtATimeTheSameWorker) {
  WorkerPool pool(3, "test");
  std::vector<std::atomic<int>> busy(pool.count());
  std::atomic<int> clashes = 0;
  pool.run(200, [&](int, int worker) {
    if (busy[worker].fetch_add(1) != 0) ++clashes;
    std::this_thread::yield();
    busy[worker].fetch_sub(1);
  });
  EXPECT_EQ(clashes, 0);
}

TEST(WorkerPool, NeedsNoJobsToEnd) {
  WorkerPool pool(3, "test");
}

TEST(WorkerPool, IsReplacedByTheCallersThreadWhereThereIsNone) {
  InlineExecutor none;
  std::vector<int> order;
  none.run(3, [&](int job, int) { order.push_back(job); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace copresence::flow
