#include "capture_server/recorder/recording_thread.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

namespace copresence::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kCheckpointEvery{500};
constexpr milliseconds kSayEvery{5000};

RgbdFrame copy_for_recording(const RgbdFrame& frame) {
  RgbdFrame copy;
  copy.metadata = frame.metadata;
  copy.depth = frame.depth;
  if (!frame.sensor_times.color_is_repeated) copy.color = frame.color;
  copy.sensor_times = frame.sensor_times;
  return copy;
}

}  // namespace

RecordingThread::RecordingThread(FrameRecording recording) : recording_(std::move(recording)) {
  spdlog::info("recording to {}", recording_.path());
  thread_ = std::jthread([this] {
    run();
    written_.set_value();
  });
}

RecordingThread::~RecordingThread() {
  waiting_.close();
  Instant never = Instant::max();
  give_up_at_.compare_exchange_strong(never, steady_clock::now());
  const auto written = written_.get_future();
  const Instant since = steady_clock::now();
  while (written.wait_for(kSayEvery) == std::future_status::timeout) {
    spdlog::warn(
        "{}: waiting for the disk to take the last frames, for {:.0f} s so far: it is slow or stands still",
        recording_.path(), std::chrono::duration<double>(steady_clock::now() - since).count());
  }
}

void RecordingThread::offer(const RgbdFrame& frame, bool may_wait, std::stop_token stop) {
  if (may_wait) wait_for_room(stop);
  if (over_ || !waiting_.has_room() || !waiting_.put(copy_for_recording(frame))) leave_out();
}

void RecordingThread::wait_for_room(const std::stop_token& stop) {
  const Instant since = steady_clock::now();
  while (!over_ && !waiting_.wait_for_room(stop, kSayEvery) && !stop.stop_requested()) {
    spdlog::warn("{}: waiting for the disk, which has taken nothing for {:.0f} s: it is slow or stands still",
                 recording_.path(), std::chrono::duration<double>(steady_clock::now() - since).count());
  }
}

void RecordingThread::leave_out() {
  const std::uint64_t left_out = ++left_out_;
  const Instant now = steady_clock::now();
  if (over_ || left_out == said_left_out_ || now < said_left_out_at_ + kSayEvery) return;
  said_left_out_ = left_out;
  said_left_out_at_ = now;
  spdlog::warn("{}: {} frames left out so far: the disk or this machine is too slow to record",
               recording_.path(), left_out);
}

void RecordingThread::end(milliseconds drain_for) {
  give_up_at_ = steady_clock::now() + drain_for;
  waiting_.close();
}

void RecordingThread::run() {
  pthread_setname_np(pthread_self(), "record");
  checkpoint_at_ = steady_clock::now();  // The first checkpoint follows the first frame.
  while (const auto frame = waiting_.take()) {
    const Instant now = steady_clock::now();
    if (over_ || now > give_up_at_.load()) {
      ++left_out_;
      continue;
    }
    write(*frame);
    if (!over_ && now >= checkpoint_at_) {
      if (auto safe = recording_.checkpoint(); !safe) stop_recording(safe.error());
      checkpoint_at_ = now + kCheckpointEvery;
    }
  }
  if (!over_) return finish();
  spdlog::info("{}: {} frames left out in all, since its recording ended early", recording_.path(),
               left_out_.load());
}

void RecordingThread::write(const RgbdFrame& frame) {
  const auto written = recording_.write(frame);
  if (written) return;
  ++left_out_;
  if (written.error().code == ErrorCode::kUnavailable) {
    stop_recording(written.error());
  } else if (const Instant now = steady_clock::now(); now >= said_refused_at_ + kSayEvery) {
    said_refused_at_ = now;
    spdlog::warn("frame {} is left out of the recording: {}", frame.metadata.sequence, written.error().what);
  }
}

void RecordingThread::stop_recording(const Error& error) {
  over_ = true;
  spdlog::error("{}; recording ends here, streaming goes on", error.what);
  finish();
}

void RecordingThread::finish() {
  if (auto finished = recording_.finish(); !finished) {
    spdlog::error("{}; it plays up to its last checkpoint", finished.error().what);
  }
  spdlog::info("{}: {} frames, {:.1f} MB, {} left out", recording_.path(), recording_.frames(),
               static_cast<double>(recording_.bytes()) * 1e-6, left_out_.load());
}

}  // namespace copresence::server
