#pragma once

// The only thread that uses one Kinect. libfreenect's calls for a device and its transfers must run
// on the same thread. Other threads pass work to this thread and wait.
// Thread: any other thread may call run().

#include <libfreenect.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "capture_server/drivers/kinect_v1/freenect_owners.h"
#include "common/result.h"

namespace copresence::drivers {

class FreenectThread {
 public:
  /// Time limit for opening. Some of libfreenect's transfers have no limit of their own.
  static constexpr std::chrono::milliseconds kOpensWithin{20'000};

  /// Opens the Kinect with this serial number and processes its transfers. `on_lost` is called
  /// once, on the new thread, when the transfers fail. After that run() fails.
  /// Fails with kUnavailable and libfreenect's message if libfreenect reports an error. Fails with
  /// kUnavailable, too, if the Kinect does not answer within `opens_within`. In the second case the
  /// thread closes the Kinect once it answers.
  static Result<std::unique_ptr<FreenectThread>> open(const std::string& serial,
                                                      std::function<void()> on_lost,
                                                      std::chrono::milliseconds opens_within = kOpensWithin);
  ~FreenectThread();
  FreenectThread(const FreenectThread&) = delete;
  FreenectThread& operator=(const FreenectThread&) = delete;

  /// Runs `work` on the thread and returns its result, or -1 if the camera is lost.
  int run(const std::function<int(freenect_device*)>& work);

 private:
  // The thread's data. The data outlives the object if the Kinect does not answer.
  struct Shared {
    std::string serial;
    std::function<void()> on_lost;
    FreenectContext context;
    freenect_device* device = nullptr;

    std::mutex mutex;
    std::condition_variable changed;
    enum class State { kOpening, kRefused, kOpen, kLost } state = State::kOpening;
    std::string refusal;
    const std::function<int(freenect_device*)>* work = nullptr;  // The work that run() waits for.
    int result = 0;
  };

  explicit FreenectThread(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}
  static void live(Shared& shared, const std::stop_token& stop);
  static bool open_device(Shared& shared);
  static void do_work(Shared& shared);

  const std::shared_ptr<Shared> shared_;
  std::mutex one_at_a_time_;  // run() holds this mutex, so that calls take turns.
  std::jthread thread_;
};

}  // namespace copresence::drivers
