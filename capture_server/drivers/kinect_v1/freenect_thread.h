#pragma once

// The one thread that talks to one Kinect: libfreenect's calls for a device and its transfers are not to be
// mixed between threads. Others hand it work and wait.
//
// Thread: run() from any thread but this one.

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
  /// How long opening may take: some of libfreenect's transfers have no limit of their own.
  static constexpr std::chrono::milliseconds kOpensWithin{20'000};

  /// Opens the Kinect with this serial number and keeps its transfers going. `on_lost` is called once, on the
  /// thread, when they fail; from then on run() fails.
  /// Fails  kUnavailable with libfreenect's words, or where the Kinect does not answer within `opens_within`. The thread
  ///        then stays behind until it does, and closes the device.
  static Result<std::unique_ptr<FreenectThread>> open(const std::string& serial,
                                                      std::function<void()> on_lost,
                                                      std::chrono::milliseconds opens_within = kOpensWithin);
  /// Closes the device.
  ~FreenectThread();
  FreenectThread(const FreenectThread&) = delete;
  FreenectThread& operator=(const FreenectThread&) = delete;

  /// Runs `work` on the thread and returns what it returned; -1 when the camera is lost.
  int run(const std::function<int(freenect_device*)>& work);

 private:
  // What the thread works with: it may outlive the object where it does not answer.
  struct Shared {
    std::string serial;
    std::function<void()> on_lost;
    FreenectContext context;
    freenect_device* device = nullptr;

    std::mutex mutex;
    std::condition_variable changed;
    enum class State { kOpening, kRefused, kOpen, kLost } state = State::kOpening;
    std::string refusal;
    const std::function<int(freenect_device*)>* work = nullptr;  // that somebody waits for
    int result = 0;
  };

  explicit FreenectThread(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}
  static void live(Shared& shared, const std::stop_token& stop);
  static bool open_device(Shared& shared);
  static void do_work(Shared& shared);

  const std::shared_ptr<Shared> shared_;
  std::mutex one_at_a_time_;  // of those who have work
  std::jthread thread_;
};

}  // namespace copresence::drivers
