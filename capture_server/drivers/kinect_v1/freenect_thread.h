#pragma once

// The one thread that talks to one Kinect: libfreenect's calls for a device and its transfers are not to be mixed between
// threads. Others hand it work and wait.
//
// Thread: run() from any thread but this one.

#include <libfreenect.h>

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
  /// Opens the Kinect with this serial number and keeps its transfers going. `on_lost` is called once, on the thread,
  /// when they fail; from then on run() fails.
  /// Fails  kUnavailable with libfreenect's words.
  static Result<std::unique_ptr<FreenectThread>> open(const std::string& serial,
                                                      std::function<void()> on_lost);
  /// Closes the device.
  ~FreenectThread();
  FreenectThread(const FreenectThread&) = delete;
  FreenectThread& operator=(const FreenectThread&) = delete;

  /// Runs `work` on the thread and returns what it returned; -1 when the camera is lost.
  int run(const std::function<int(freenect_device*)>& work);

 private:
  FreenectThread(std::string serial, std::function<void()> on_lost);
  void live(const std::stop_token& stop);
  bool open_device();
  void do_work();

  const std::string serial_;
  const std::function<void()> on_lost_;
  FreenectContext context_;
  freenect_device* device_ = nullptr;

  std::mutex mutex_;
  std::condition_variable changed_;
  enum class State { kOpening, kRefused, kOpen, kLost } state_ = State::kOpening;
  std::string refusal_;
  const std::function<int(freenect_device*)>* work_ = nullptr;  // that somebody waits for
  int result_ = 0;
  std::mutex one_at_a_time_;  // of those who have work
  std::jthread thread_;
};

}  // namespace copresence::drivers
