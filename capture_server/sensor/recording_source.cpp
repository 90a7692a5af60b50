#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/color_pairing.h"
#include "capture_server/sensor/core_shortage.h"
#include "capture_server/sensor/frame_source.h"
#include "capture_server/sensor/open_ni.h"
#include "capture_server/sensor/playback_schedule.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// A damaged recording may fall silent. So does a player that gets no core: it is given the time that it lost, up to what
// the supervisor takes for a hang.
constexpr Duration kStallAfter = std::chrono::seconds(1), kStallAfterAtMost = std::chrono::seconds(4);
constexpr int kSliceMs = 50;  // how long a stop request may go unseen
constexpr std::int64_t kReuseColorUs = 100'000;
constexpr std::size_t kDepthsAhead = 4;  // how far a recording's colour may lag behind its depth in the file

// A path of the player's own: it crashes on characters beyond ASCII and takes 255 of them.
class FileDescriptor {
 public:
  explicit FileDescriptor(const std::string& path) : number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~FileDescriptor() {
    if (number_ >= 0) ::close(number_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;

  bool is_open() const { return number_ >= 0; }
  std::string path() const { return fmt::format("/proc/self/fd/{}", number_); }

 private:
  int number_;
};

// The player tells its end to whoever listens, and to nobody who waits for a frame.
class EndListener final : public openni::OpenNI::DeviceStateChangedListener {
 public:
  explicit EndListener(std::string uri) : uri_(std::move(uri)) {
    openni::OpenNI::addDeviceStateChangedListener(this);
  }
  ~EndListener() override { openni::OpenNI::removeDeviceStateChangedListener(this); }
  EndListener(const EndListener&) = delete;
  EndListener& operator=(const EndListener&) = delete;

  bool ended() const { return ended_; }

  void onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) override {
    if (state == openni::DEVICE_STATE_EOF && uri_ == device->getUri()) ended_ = true;
  }

 private:
  const std::string uri_;
  std::atomic<bool> ended_ = false;
};

// One stream's place in the recording: its frames count from 1 in every pass.
struct Track {
  std::uint64_t last = 0;   // number of a pass's last frame
  std::uint64_t index = 0;  // number of the frame that came last
  std::uint64_t pass = 0;
  std::int64_t timestamp_us = 0;

  bool at_end() const { return index >= last; }

  // Returns how many frames are missing between the last one and this.
  std::uint64_t advance(const openni::VideoFrameRef& frame, std::int64_t duration_us) {
    const auto next = static_cast<std::uint64_t>(std::max(frame.getFrameIndex(), 1));
    const bool begins_again = next <= index;
    const std::uint64_t missing =
        begins_again ? next - 1 + (last > index ? last - index : 0) : next - index - 1;
    pass += begins_again;
    index = next;
    // Time goes on over the seam and never back.
    const auto unwrapped =
        static_cast<std::int64_t>(frame.getTimestamp() + pass * static_cast<std::uint64_t>(duration_us));
    timestamp_us = std::max(timestamp_us, unwrapped);
    return missing;
  }
};

class RecordingSource final : public FrameSource {
 public:
  RecordingSource(CheckedRecording recording, const SourceSettings& settings)
      : recording_(std::move(recording)),
        settings_(settings),
        file_(recording_.path),
        end_(file_.path()),
        pairing_(static_cast<std::int64_t>(recording_.period_us / 2), kReuseColorUs) {
    depth_track_.last = recording_.last_depth_frame;
    color_track_.last = recording_.last_color_frame;
  }

  ~RecordingSource() override {
    halt();
    let_threads_leave();
    // Streams first: closing the device frees them, and they would be freed again.
    color_.destroy();
    depth_.destroy();
    device_.close();
  }

  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  Result<void> start();
  const SensorDescription& description() const override { return recording_.description; }
  SourceCounters counters() const override;
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  using Pairing = ColorPairing<openni::VideoFrameRef>;

  Result<void> refused(const std::string& what) const;
  Result<Pairing::Pair> next_pair(const std::stop_token& stop);
  bool read_one();
  void halt();

  CheckedRecording recording_;
  const SourceSettings settings_;
  const OpenNiSession session_{drivers::kNoDriver};
  const FileDescriptor file_;
  const EndListener end_;
  openni::Device device_;
  openni::VideoStream depth_;
  openni::VideoStream color_;
  bool playing_ = false;

  Track depth_track_;
  Track color_track_;
  Pairing pairing_;
  PlaybackSchedule schedule_;
  SourceCounters counters_;
};

Result<void> RecordingSource::refused(const std::string& what) const {
  return fail(ErrorCode::kCorrupt, fmt::format("{}: OpenNI2 does not play it: {} ({}); record it again",
                                               recording_.path, what, last_open_ni_error()));
}

Result<void> RecordingSource::start() {
  if (!session_.is_up()) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("OpenNI2 does not start: {}; install the package libopenni2-0 again",
                            last_open_ni_error()));
  }
  if (!file_.is_open()) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: {}; give the path of an .oni recording",
                                                  recording_.path, std::strerror(errno)));
  }
  if (device_.open(file_.path().c_str()) != openni::STATUS_OK) return refused("it does not open");
  openni::PlaybackControl* playback = device_.getPlaybackControl();
  if (!playback) return refused("it does not open as a recording");
  // -1: a frame is released for each one waited for, so that none is lost whatever our own pace.
  if (playback->setSpeed(-1) != openni::STATUS_OK ||
      playback->setRepeatEnabled(settings_.loop) != openni::STATUS_OK) {
    return refused("its speed cannot be set");
  }
  const bool has_color = recording_.description.has_color;
  // A stream that is created must be started and read, or the others stall.
  if (depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK ||
      (has_color && color_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK)) {
    return refused("its streams do not open");
  }
  recording_.description.levels = levels_of(depth_);
  playing_ = true;
  if (depth_.start() != openni::STATUS_OK || (has_color && color_.start() != openni::STATUS_OK)) {
    return refused("its streams do not start");
  }
  return {};
}

void RecordingSource::halt() {
  if (!playing_) return;
  playing_ = false;
  depth_.stop();
  if (color_.isValid()) color_.stop();
}

SourceCounters RecordingSource::counters() const {
  SourceCounters counters = counters_;
  counters.color_without_depth = pairing_.unused_color();
  return counters;
}

// One picture from the player into the pairing; false when none came for a moment.
bool RecordingSource::read_one() {
  openni::VideoStream* streams[] = {&depth_, &color_};
  const bool has_color = recording_.description.has_color;
  int ready = 0;
  if (openni::OpenNI::waitForAnyStream(streams, has_color ? 2 : 1, &ready, kSliceMs) != openni::STATUS_OK)
    return false;
  const bool is_depth = ready == 0;
  openni::VideoFrameRef picture;
  if (streams[ready]->readFrame(&picture) != openni::STATUS_OK) return false;
  Track& track = is_depth ? depth_track_ : color_track_;
  counters_.damaged += track.advance(picture, recording_.duration_us);
  const CameraModel& camera = is_depth ? recording_.description.depth : recording_.description.color;
  if (!is_whole(picture, camera, is_depth ? 2 : 3)) {
    ++counters_.damaged;
  } else if (is_depth) {
    pairing_.add_depth(track.timestamp_us, picture);
  } else {
    pairing_.add_color(track.timestamp_us, picture);
  }
  return true;
}

Result<RecordingSource::Pairing::Pair> RecordingSource::next_pair(const std::stop_token& stop) {
  const bool has_color = recording_.description.has_color;
  const Instant begin = steady_clock::now();
  std::optional<Duration> waited_before;
  while (true) {
    const bool may_wait = has_color && playing_ && pairing_.waiting() <= kDepthsAhead;
    if (auto pair = pairing_.take(may_wait)) return std::move(*pair);
    if (!playing_ && counters_.frames == 0) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{}: none of its {} frames could be decoded; take another copy of the file or "
                              "record it again",
                              recording_.path, depth_track_.last));
    }
    if (!playing_) {
      return fail(ErrorCode::kEndOfStream, fmt::format("{}: the recording has ended", recording_.path));
    }
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    const bool got_one = read_one();
    const bool everything_read =
        !settings_.loop && depth_track_.at_end() && (!has_color || color_track_.at_end());
    // At its end the player's thread spins until it is stopped.
    if (everything_read || (!got_one && end_.ended())) {
      halt();
      continue;
    }
    if (got_one) continue;
    if (!waited_before) waited_before = waited_for_a_core();
    const Duration silent = steady_clock::now() - begin;
    if (silent > kStallAfter &&
        (silent > kStallAfterAtMost || silent > kStallAfter + (waited_for_a_core() - *waited_before))) {
      halt();
      return fail(ErrorCode::kTimeout,
                  fmt::format("{}: no frame for {:.0f} s after frame {} of {}: it is damaged there, or this "
                              "machine is far too busy; record it again or end other programs",
                              recording_.path, std::chrono::duration<double>(silent).count(),
                              depth_track_.index, depth_track_.last));
    }
  }
}

Result<RgbdFrame> RecordingSource::next(std::stop_token stop) {
  const Instant begin = steady_clock::now();
  auto pair = next_pair(stop);
  if (!pair) return fail(pair.error());
  RgbdFrame frame;
  copy_depth(pair->depth, recording_.description.depth, frame);
  if (pair->color) copy_color(*pair->color, recording_.description.color, frame);
  const Instant ready = steady_clock::now();
  frame.durations.capture = ready - begin;
  frame.stamp.captured_at = ready;
  if (settings_.pace == SourceSettings::Pace::kReal) {
    const Instant due = schedule_.due(pair->timestamp_us, ready);
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_until(lock, stop, due, [] { return false; });
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    frame.stamp.captured_at = steady_clock::now();
  }
  frame.sensor_times = Pairing::times_of(*pair);
  frame.stamp.sequence = ++counters_.frames;
  frame.stamp.world_from_camera = recording_.description.world_from_camera.value_or(Rigid3{});
  if (recording_.description.has_color && !pair->same_instant) ++counters_.depth_without_color;
  return frame;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording(const CheckedRecording& recording,
                                                    const SourceSettings& settings) {
  assert(recording.last_depth_frame > 0 && recording.duration_us > 0);
  auto source = std::make_unique<RecordingSource>(recording, settings);
  if (auto started = source->start(); !started) return fail(started.error());
  return source;
}

}  // namespace copresence::sensor
