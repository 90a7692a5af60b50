#include "capture_server/drivers/kinect_v1/freenect_thread.h"

#include <pthread.h>
#include <sys/time.h>

namespace copresence::drivers {
namespace {

constexpr int kInterrupted = -10;  // libusb's, when a signal came: nothing is wrong
constexpr long kSliceUs = 5000;    // how long work may wait for the thread

}  // namespace

Result<std::unique_ptr<FreenectThread>> FreenectThread::open(const std::string& serial,
                                                             std::function<void()> on_lost) {
  std::unique_ptr<FreenectThread> made(new FreenectThread(serial, std::move(on_lost)));
  made->thread_ = std::jthread([device = made.get()](const std::stop_token& stop) { device->live(stop); });
  std::unique_lock lock(made->mutex_);
  made->changed_.wait(lock, [&] { return made->state_ != State::kOpening; });
  if (made->state_ != State::kRefused) return made;
  const std::string why = made->refusal_;
  lock.unlock();
  return fail(ErrorCode::kUnavailable, why);
}

FreenectThread::FreenectThread(std::string serial, std::function<void()> on_lost)
    : serial_(std::move(serial)), on_lost_(std::move(on_lost)) {}

FreenectThread::~FreenectThread() = default;

// With its motor where there is one: a Kinect for Windows has none that opens like this.
bool FreenectThread::open_device() {
  for (const int parts : {FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR, int{FREENECT_DEVICE_CAMERA}}) {
    context_ = make_freenect_context(parts);
    if (!context_) continue;
    if (freenect_open_device_by_camera_serial(context_.get(), &device_, serial_.c_str()) >= 0 && device_)
      return true;
    device_ = nullptr;
  }
  return false;
}

void FreenectThread::do_work() {
  std::unique_lock lock(mutex_);
  if (!work_) return;
  const auto* work = work_;
  lock.unlock();
  const int result = (*work)(device_);
  lock.lock();
  result_ = result;
  work_ = nullptr;
  changed_.notify_all();
}

void FreenectThread::live(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "kinect");
  const bool opened = open_device();
  {
    const std::lock_guard lock(mutex_);
    state_ = opened ? State::kOpen : State::kRefused;
    refusal_ = last_freenect_error();
    changed_.notify_all();
  }
  if (!opened) return;
  while (!stop.stop_requested()) {
    timeval slice{0, kSliceUs};
    const int processed = freenect_process_events_timeout(context_.get(), &slice);
    if (processed < 0 && processed != kInterrupted) break;
    do_work();
  }
  {
    const std::lock_guard lock(mutex_);
    state_ = State::kLost;
    work_ = nullptr;
    result_ = -1;
    changed_.notify_all();
  }
  if (!stop.stop_requested()) on_lost_();
  freenect_stop_depth(device_);
  freenect_stop_video(device_);
  freenect_close_device(device_);
  context_.reset();
}

int FreenectThread::run(const std::function<int(freenect_device*)>& work) {
  const std::lock_guard turn(one_at_a_time_);
  std::unique_lock lock(mutex_);
  if (state_ != State::kOpen) return -1;
  work_ = &work;
  changed_.wait(lock, [&] { return work_ == nullptr; });
  return result_;
}

}  // namespace copresence::drivers
