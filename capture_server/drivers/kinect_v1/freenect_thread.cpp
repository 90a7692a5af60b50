#include "capture_server/drivers/kinect_v1/freenect_thread.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/time.h>

namespace copresence::drivers {
namespace {

constexpr int kInterrupted = -10;  // libusb's code for an interruption by a signal, which is not an error.
constexpr long kSliceUs = 5000;    // Longest time that a call of run() waits for the thread.

}  // namespace

Result<std::unique_ptr<FreenectThread>> FreenectThread::open(const std::string& serial,
                                                             std::function<void()> on_lost,
                                                             std::chrono::milliseconds opens_within) {
  auto shared = std::make_shared<Shared>();
  shared->serial = serial;
  shared->on_lost = std::move(on_lost);
  std::unique_ptr<FreenectThread> made(new FreenectThread(shared));
  made->thread_ = std::jthread([shared](const std::stop_token& stop) { live(*shared, stop); });
  std::unique_lock lock(shared->mutex);
  const bool answered =
      shared->changed.wait_for(lock, opens_within, [&] { return shared->state != Shared::State::kOpening; });
  if (!answered) {
    made->thread_.request_stop();
    made->thread_.detach();
    return fail(ErrorCode::kUnavailable,
                fmt::format("the Kinect does not answer within {} s: unplug it and plug it in again",
                            std::chrono::duration<double>(opens_within).count()));
  }
  if (shared->state == Shared::State::kRefused) return fail(ErrorCode::kUnavailable, shared->refusal);
  return made;
}

FreenectThread::~FreenectThread() = default;

// Opens camera and motor. Without a motor, or for a Kinect for Windows, opens only the camera.
bool FreenectThread::open_device(Shared& shared) {
  for (const int parts : {FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR, int{FREENECT_DEVICE_CAMERA}}) {
    shared.context = make_freenect_context(parts);
    if (!shared.context) continue;
    if (freenect_open_device_by_camera_serial(shared.context.get(), &shared.device, shared.serial.c_str()) >=
            0 &&
        shared.device)
      return true;
    shared.device = nullptr;
  }
  return false;
}

void FreenectThread::do_work(Shared& shared) {
  std::unique_lock lock(shared.mutex);
  if (!shared.work) return;
  const auto* work = shared.work;
  lock.unlock();
  const int result = (*work)(shared.device);
  lock.lock();
  shared.result = result;
  shared.work = nullptr;
  shared.changed.notify_all();
}

void FreenectThread::live(Shared& shared, const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "kinect");
  const bool opened = open_device(shared);
  {
    const std::lock_guard lock(shared.mutex);
    shared.state = opened ? Shared::State::kOpen : Shared::State::kRefused;
    shared.refusal = last_freenect_error();
    shared.changed.notify_all();
  }
  if (!opened) return;
  while (!stop.stop_requested()) {
    timeval slice{0, kSliceUs};
    const int processed = freenect_process_events_timeout(shared.context.get(), &slice);
    if (processed < 0 && processed != kInterrupted) break;
    do_work(shared);
  }
  {
    const std::lock_guard lock(shared.mutex);
    shared.state = Shared::State::kLost;
    shared.work = nullptr;
    shared.result = -1;
    shared.changed.notify_all();
  }
  if (!stop.stop_requested()) shared.on_lost();
  freenect_stop_depth(shared.device);
  freenect_stop_video(shared.device);
  freenect_close_device(shared.device);
  shared.context.reset();
}

int FreenectThread::run(const std::function<int(freenect_device*)>& work) {
  const std::lock_guard turn(one_at_a_time_);
  std::unique_lock lock(shared_->mutex);
  if (shared_->state != Shared::State::kOpen) return -1;
  shared_->work = &work;
  shared_->changed.wait(lock, [&] { return shared_->work == nullptr; });
  return shared_->result;
}

}  // namespace copresence::drivers
