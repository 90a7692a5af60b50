#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/cpu_starvation.h"
#include "capture_server/sensor/frame_source.h"
#include "capture_server/sensor/frame_synchronizer.h"
#include "capture_server/sensor/open_ni.h"
#include "capture_server/sensor/playback_schedule.h"
#include "capture_server/sensor/read_position.h"
#include "capture_server/sensor/recording_track.h"
#include "capture_server/sensor/session_clock.h"
#include "common/flow/waiting.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// A damaged recording may fall silent, or come without any depth. So may a player that gets no core: it is given the time
// that it lost, up to what the supervisor takes for a hang.
constexpr Duration kUsualSilence = std::chrono::seconds(1);
constexpr StallTimeout kStallTimeout{kUsualSilence, std::chrono::seconds(4)};
// How long next() may keep its caller without a frame, though all is well but for the pictures.
constexpr Duration kSignOfLife = std::chrono::seconds(1);
constexpr int kSliceMs = 50;  // how long a stop request may go unseen
// What counts as silence of a slice that took longer: this process was suspended then.
constexpr Duration kMostALook = milliseconds(500);
constexpr std::int64_t kReuseColorUs = 100'000;
// A frame that its session showed longer ago is left out.
constexpr Duration kLate = milliseconds(200);
// A replay that is not looped leaves out so much of its beginning at most to be in step with its session.
constexpr Duration kLatestJoin = std::chrono::seconds(10);
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
  int number() const { return number_; }
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
  void begin_again() { ended_ = false; }

  void onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) override {
    if (state == openni::DEVICE_STATE_EOF && uri_ == device->getUri()) ended_ = true;
  }

 private:
  const std::string uri_;
  std::atomic<bool> ended_ = false;
};

class RecordingSource final : public FrameSource {
 public:
  RecordingSource(CheckedRecording recording, const SourceSettings& settings)
      : recording_(std::move(recording)),
        settings_(settings),
        file_(recording_.path),
        end_(file_.path()),
        depth_track_(recording_.last_depth_frame, recording_.duration_us),
        color_track_(recording_.last_color_frame, recording_.duration_us),
        pairing_(static_cast<std::int64_t>(recording_.period_us / 2), kReuseColorUs),
        schedule_(std::chrono::microseconds(std::llround(recording_.period_us)), settings_.begin) {}

  ~RecordingSource() override { close(); }

  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  Result<void> start();
  const SensorDescription& description() const override { return recording_.description; }
  SourceCounters counters() const override;
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  using Pairing = FrameSynchronizer<openni::VideoFrameRef>;

  Result<void> refused(const std::string& what) const;
  Result<void> open_player();
  Result<Pairing::Pair> next_pair(const std::stop_token& stop);
  Result<Pairing::Pair> next_shown(const std::stop_token& stop, Instant& due);
  std::optional<Instant> due_of(const Pairing::Pair& pair);
  void join_session(Instant now);
  Result<RgbdFrame> wait_out(const std::stop_token& stop);
  bool read_one();
  Result<void> reach_end();
  void count_missing_until(std::uint64_t pass);
  tl::unexpected<Error> ended() const;
  tl::unexpected<Error> stalled(Duration silent) const;
  tl::unexpected<Error> nothing_decodes(std::uint64_t first) const;
  void halt();
  void close();

  CheckedRecording recording_;
  const SourceSettings settings_;
  const OpenNiSession session_{drivers::kNoDriver};
  const FileDescriptor file_;
  EndListener end_;
  openni::Device device_;
  openni::VideoStream depth_;
  openni::VideoStream color_;
  bool playing_ = false;
  // Not before a depth picture has come: a player that repeats without ever having one spins, and may lock itself up.
  bool repeats_ = false;

  // Of a recording none of whose depth can be decoded, once that is known: its time passes without the player.
  std::optional<Instant> begun_, pass_ends_;
  std::uint64_t lost_by_pass_ = 0;

  RecordingTrack depth_track_;
  RecordingTrack color_track_;
  Pairing pairing_;
  PlaybackSchedule schedule_;
  SourceCounters counters_;

  bool session_is_looked_for_ = false;
  std::optional<SessionClock> replays_;   // of which this replay is one, where it is
  std::int64_t first_round_ = 0;          // of the session, in which this replay's first pass lies
  std::optional<Pairing::Pair> pending_;  // read, but due only later
  Instant pending_due_{};
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
  return open_player();
}

Result<void> RecordingSource::open_player() {
  if (device_.open(file_.path().c_str()) != openni::STATUS_OK) return refused("it does not open");
  openni::PlaybackControl* playback = device_.getPlaybackControl();
  if (!playback) return refused("it does not open as a recording");
  // -1: a frame is released for each one waited for, so that none is lost whatever our own pace.
  if (playback->setSpeed(-1) != openni::STATUS_OK ||
      playback->setRepeatEnabled(repeats_) != openni::STATUS_OK) {
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

void RecordingSource::close() {
  halt();
  let_threads_leave();
  // Streams first: closing the device frees them, and they would be freed again.
  color_.destroy();
  depth_.destroy();
  device_.close();
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
  RecordingTrack& track = is_depth ? depth_track_ : color_track_;
  counters_.damaged += track.advance(static_cast<std::uint64_t>(std::max(picture.getFrameIndex(), 1)),
                                     static_cast<std::int64_t>(picture.getTimestamp()));
  // The other stream may be a pass behind, where its last pictures are still to come, but no more.
  if (track.pass() > 0) count_missing_until(track.pass() - 1);
  const CameraModel& camera = is_depth ? recording_.description.depth : recording_.description.color;
  if (!is_whole(picture, camera, is_depth ? 2 : 3)) {
    ++counters_.damaged;
  } else if (is_depth) {
    pairing_.add_depth(track.timestamp_us(), picture);
    if (settings_.loop && !std::exchange(repeats_, true))
      device_.getPlaybackControl()->setRepeatEnabled(
          true);  // too late where this one was the last: see reach_end()
  } else {
    pairing_.add_color(track.timestamp_us(), picture);
  }
  return true;
}

void RecordingSource::count_missing_until(std::uint64_t pass) {
  counters_.damaged += depth_track_.begin_pass(pass);
  if (recording_.description.has_color) counters_.damaged += color_track_.begin_pass(pass);
}

// The player has come to its end, where its thread spins until it is stopped. Fails with what next() shall say.
Result<void> RecordingSource::reach_end() {
  if (repeats_) {
    close();
    end_.begin_again();
    const auto opened = open_player();
    return opened ? Result<void>() : fail(ErrorCode::kNotFound, opened.error().what);
  }
  halt();
  count_missing_until(depth_track_.pass() + 1);
  if (counters_.frames == 0 && !pairing_.has_depth()) {
    lost_by_pass_ = counters_.damaged;
    pass_ends_ = *begun_ + std::chrono::microseconds(recording_.duration_us);
    return nothing_decodes(1);
  }
  return {};
}

tl::unexpected<Error> RecordingSource::nothing_decodes(std::uint64_t first) const {
  return fail(ErrorCode::kCorrupt, fmt::format("{}: its depth pictures from {} on cannot be decoded; take "
                                               "another copy of the file or record it again",
                                               recording_.path, first));
}

tl::unexpected<Error> RecordingSource::ended() const {
  return fail(ErrorCode::kEndOfStream, fmt::format("{}: the recording has ended", recording_.path));
}

tl::unexpected<Error> RecordingSource::stalled(Duration silent) const {
  return fail(ErrorCode::kTimeout,
              fmt::format("{}: no frame for {:.0f} s after frame {} of {}: it is damaged there, or this "
                          "machine is far too busy; record it again or end other programs",
                          recording_.path, std::chrono::duration<double>(silent).count(),
                          depth_track_.index(), depth_track_.last()));
}

// For the next frame of a recording that has none.
Result<RgbdFrame> RecordingSource::wait_out(const std::stop_token& stop) {
  const bool keeps_pace = settings_.loop || settings_.pace == SourceSettings::Pace::kReal;
  if (keeps_pace) {
    const Instant until = std::min(*pass_ends_, steady_clock::now() + kSignOfLife);
    wait_until(until, stop);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    if (until < *pass_ends_) return nothing_decodes(1);
  }
  if (!settings_.loop) return ended();
  *pass_ends_ += std::chrono::microseconds(recording_.duration_us);
  counters_.damaged += lost_by_pass_;
  return nothing_decodes(1);
}

Result<RecordingSource::Pairing::Pair> RecordingSource::next_pair(const std::stop_token& stop) {
  const bool has_color = recording_.description.has_color;
  WatchedTime time;
  const Instant begin = time.look(kMostALook);
  Instant heard = begin;      // of the player
  Instant had_depth = begin;  // of which a pair has not come yet: its colour may be late
  std::optional<std::uint64_t> position;
  std::optional<Duration> waited_before;
  while (true) {
    const bool may_wait = has_color && playing_ && pairing_.waiting() <= kDepthsAhead;
    if (auto pair = pairing_.take(may_wait)) return std::move(*pair);
    if (!playing_) return ended();
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    const std::size_t depths_before = pairing_.waiting();
    const bool got_one = read_one();
    const Instant now = time.look(kMostALook);
    if (pairing_.waiting() > depths_before) had_depth = now;
    const bool everything_read = !repeats_ && depth_track_.at_end() && (!has_color || color_track_.at_end());
    if (everything_read || (!got_one && end_.ended())) {
      if (const auto end = reach_end(); !end) return fail(end.error());
      continue;
    }
    if (!got_one && !position) {
      position = read_position_beside(file_.number());
      waited_before = waited_for_a_core();
    }
    const auto has_had_time = [&](Duration silent) {
      return kStallTimeout.is_over(silent,
                                   waited_before ? waited_for_a_core() - *waited_before : Duration::zero());
    };
    if (got_one) {
      heard = now;
    } else if (const Duration silent = now - heard; silent > kUsualSilence) {
      // What the player cannot decode it passes over without a word, however much of it there is.
      const auto position_before = std::exchange(position, read_position_beside(file_.number()));
      if (position != position_before) {
        heard = now;
      } else if (has_had_time(silent)) {
        halt();
        return stalled(silent);
      }
    }
    if (now - had_depth > kUsualSilence && heard > begin && has_had_time(now - had_depth))
      return nothing_decodes(depth_track_.index() + 1);
  }
}

void RecordingSource::join_session(Instant now) {
  if (std::exchange(session_is_looked_for_, true) || settings_.begin || !recording_.began_unix_us) return;
  const SessionSpan own{*recording_.began_unix_us, *recording_.began_unix_us + recording_.duration_us};
  replays_ = SessionClock::join(SessionClock::default_folder(), own, PlaybackSchedule::in_sync(now));
  if (!replays_) return;
  const SessionTimeline& timeline = replays_->timeline();
  first_round_ = timeline.round_at(own, now);
  const Instant own_begin = timeline.due(std::max(own.from_us, timeline.span().from_us), 0);
  if (!settings_.loop && (first_round_ > 0 || now - own_begin > kLatestJoin)) replays_.reset();
}

// Nothing where the session does not show this pair, or has shown it already.
std::optional<Instant> RecordingSource::due_of(const Pairing::Pair& pair) {
  const Instant now = steady_clock::now();
  join_session(now);
  if (!replays_) return schedule_.due(pair.timestamp_us, now);
  const std::int64_t since_first = pair.timestamp_us - recording_.first_us;
  const std::int64_t session_us = *recording_.began_unix_us + since_first % recording_.duration_us;
  const SessionTimeline& timeline = replays_->timeline();
  const Instant due = timeline.due(session_us, first_round_ + since_first / recording_.duration_us);
  if (!timeline.contains(session_us) || now - due > kLate) return std::nullopt;
  return due;
}

// The next pair that is shown, at most kSignOfLife before it is due.
Result<RecordingSource::Pairing::Pair> RecordingSource::next_shown(const std::stop_token& stop,
                                                                   Instant& due) {
  const Instant begin = steady_clock::now();
  while (true) {
    if (!pending_) {
      auto pair = next_pair(stop);
      if (!pair) return fail(pair.error());
      const auto when = due_of(*pair);
      if (!when && steady_clock::now() - begin < kSignOfLife) continue;
      if (!when) {
        return fail(
            ErrorCode::kUnavailable,
            fmt::format("{}: goes forward to where the other replays of its session are", recording_.path));
      }
      pending_ = std::move(*pair);
      pending_due_ = *when;
    }
    const Instant now = steady_clock::now();
    if (replays_ && pending_due_ - now > kSignOfLife) {
      wait_until(now + kSignOfLife, stop);
      if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
      return fail(
          ErrorCode::kUnavailable,
          fmt::format("{}: its session has begun, but this camera's part of it has not", recording_.path));
    }
    due = pending_due_;
    Pairing::Pair pair = std::move(*pending_);
    pending_.reset();
    return pair;
  }
}

Result<RgbdFrame> RecordingSource::next(std::stop_token stop) {
  const Instant begin = steady_clock::now();
  if (!begun_) begun_ = begin;
  if (pass_ends_) return wait_out(stop);
  const bool keeps_pace = settings_.pace == SourceSettings::Pace::kReal;
  Instant due{};
  auto pair = keeps_pace ? next_shown(stop, due) : next_pair(stop);
  if (!pair) return fail(pair.error());
  RgbdFrame frame;
  copy_depth(pair->depth, recording_.description.depth, frame);
  if (pair->color) copy_color(*pair->color, recording_.description.color, frame);
  const Instant ready = steady_clock::now();
  frame.durations.capture = ready - begin;
  frame.metadata.captured_at = ready;
  if (keeps_pace) {
    wait_until(due, stop);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    frame.metadata.captured_at = steady_clock::now();
  }
  frame.sensor_times = Pairing::times_of(*pair);
  frame.metadata.sequence = ++counters_.frames;
  frame.metadata.world_from_camera = recording_.description.world_from_camera.value_or(Rigid3{});
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
