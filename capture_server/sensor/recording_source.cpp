#include "capture_server/sensor/recording_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "capture_server/recording/oni_reader.h"
#include "capture_server/sensor/frame_synchronizer.h"
#include "capture_server/sensor/recording_description.h"
#include "capture_server/sensor/replay_clock.h"
#include "common/flow/waiting.h"

namespace copresence::sensor {
namespace {

using recording::RecordedStream;
using std::chrono::steady_clock;

// next() returns after at most this time, with a frame or with an error that is not final.
constexpr Duration kSignOfLife = std::chrono::seconds(1);
constexpr std::int64_t kReuseColorUs = 100'000;
constexpr std::size_t kDepthsAhead = 4;  // Number of depth frames by which colour may lag behind in the file.

class RecordingSource final : public FrameSource {
 public:
  RecordingSource(const std::string& path, recording::OniReader reader, const SourceSettings& settings)
      : path_(path),
        settings_(settings),
        reader_(std::move(reader)),
        recording_(describe(path, reader_.summary())),
        synchronizer_(static_cast<std::int64_t>(recording_.period_us / 2), kReuseColorUs),
        clock_(recording_, settings_) {
    using Kind = RecordedStream::Kind;
    streams_[kDepth].recorded = reader_.summary().find(Kind::kDepth);
    if (recording_.sensor.has_color) streams_[kColor].recorded = reader_.summary().find(Kind::kColor);
    begin_pass(0);
  }

  const SensorDescription& description() const override { return recording_.sensor; }
  SourceCounters counters() const override;
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  // A frame with a single picture: depth and state, or colour.
  using Picture = std::shared_ptr<RgbdFrame>;
  using Synchronizer = FrameSynchronizer<Picture>;
  using Pair = Synchronizer::Pair;

  enum StreamIndex { kDepth, kColor };

  // A stream's position in the recording.
  struct Stream {
    const RecordedStream* recorded = nullptr;
    std::size_t next = 0;           // Index of the next picture in this pass.
    std::int64_t timestamp_us = 0;  // Time of the last picture over all passes. Does not decrease.

    bool has_next() const { return recorded && next < recorded->frames(); }
    std::uint64_t position() const { return recorded->payloads[next].position; }
  };

  void begin_pass(std::int64_t pass);
  bool read_one();
  Result<void> end_pass();
  Result<Pair> next_pair(const std::stop_token& stop);
  Result<Pair> next_shown(const std::stop_token& stop, Instant& due);
  Result<RgbdFrame> wait_out(const std::stop_token& stop);
  tl::unexpected<Error> ended() const;
  tl::unexpected<Error> nothing_decodes(std::size_t first) const;

  const std::string path_;
  const SourceSettings settings_;
  const recording::OniReader reader_;
  const RecordingDescription recording_;

  std::array<Stream, 2> streams_;
  std::int64_t pass_ = 0;
  std::uint64_t damaged_before_pass_ = 0;
  bool pass_has_depth_ = false;
  bool ended_ = false;
  Synchronizer synchronizer_;
  SourceCounters counters_;

  // These members are used if no depth of the recording can be decoded. The source then waits until
  // the recording would end, but reads nothing more.
  std::optional<Instant> begun_, pass_ends_;
  std::uint64_t lost_by_pass_ = 0;

  ReplayClock clock_;
  std::optional<Pair> pending_;  // The next pair, read but not due yet.
  Instant pending_due_{};
};

tl::unexpected<Error> asked_to_stop() {
  return fail(ErrorCode::kEndOfStream, "asked to stop");
}

tl::unexpected<Error> RecordingSource::ended() const {
  return fail(ErrorCode::kEndOfStream, fmt::format("{}: the recording has ended", path_));
}

tl::unexpected<Error> RecordingSource::nothing_decodes(std::size_t first) const {
  return fail(ErrorCode::kCorrupt, fmt::format("{}: its depth pictures from {} on cannot be decoded; take "
                                               "another copy of the file or record it again",
                                               path_, first));
}

SourceCounters RecordingSource::counters() const {
  SourceCounters counters = counters_;
  counters.color_without_depth = synchronizer_.unused_color();
  return counters;
}

void RecordingSource::begin_pass(std::int64_t pass) {
  pass_ = pass;
  pass_has_depth_ = false;
  damaged_before_pass_ = counters_.damaged;
  for (Stream& stream : streams_) {
    stream.next = 0;
    if (stream.recorded) counters_.damaged += stream.recorded->last_frame - stream.recorded->frames();
  }
}

// Decodes the next picture of the file. Returns false at the end of the pass.
bool RecordingSource::read_one() {
  const Instant begin = steady_clock::now();
  Stream& depth = streams_[kDepth];
  Stream& color = streams_[kColor];
  if (!depth.has_next() && !color.has_next()) return false;
  const bool is_depth = depth.has_next() && (!color.has_next() || depth.position() < color.position());
  Stream& stream = is_depth ? depth : color;
  const std::size_t index = stream.next++;
  const auto time_us = static_cast<std::int64_t>(stream.recorded->timestamps_us[index]);
  stream.timestamp_us = std::max(stream.timestamp_us, time_us + pass_ * recording_.duration_us);

  const auto picture = std::make_shared<RgbdFrame>();
  if (is_depth) {
    auto decoded = reader_.depth(index);
    if (!decoded) {
      ++counters_.damaged;
      return true;
    }
    picture->depth = std::move(*decoded);
    picture->state.resize(picture->depth.width(), picture->depth.height());
    std::transform(picture->depth.pixels().begin(), picture->depth.pixels().end(),
                   picture->state.pixels().begin(),
                   [](std::uint16_t z) { return z ? DepthState::kMeasured : DepthState::kHole; });
    pass_has_depth_ = true;
  } else {
    auto decoded = reader_.color(index);
    if (!decoded) {
      ++counters_.damaged;
      return true;
    }
    picture->color = std::move(*decoded);
  }
  picture->durations.capture = steady_clock::now() - begin;
  if (is_depth) {
    synchronizer_.add_depth(stream.timestamp_us, picture);
  } else {
    synchronizer_.add_color(stream.timestamp_us, picture);
  }
  return true;
}

Result<void> RecordingSource::end_pass() {
  if (!pass_has_depth_) {
    const auto duration = std::chrono::microseconds(recording_.duration_us);
    pass_ends_ = (pass_ == 0 ? *begun_ : steady_clock::now()) + duration;
    lost_by_pass_ = counters_.damaged - damaged_before_pass_;
    return nothing_decodes(1);
  }
  if (settings_.loop) {
    begin_pass(pass_ + 1);
  } else {
    ended_ = true;
  }
  return {};
}

// Returns the next result for a recording without decodable depth.
Result<RgbdFrame> RecordingSource::wait_out(const std::stop_token& stop) {
  const bool keeps_pace = settings_.loop || settings_.pace == SourceSettings::Pace::kReal;
  if (keeps_pace) {
    const Instant until = std::min(*pass_ends_, steady_clock::now() + kSignOfLife);
    wait_until(until, stop);
    if (stop.stop_requested()) return asked_to_stop();
    if (until < *pass_ends_) return nothing_decodes(1);
  }
  if (!settings_.loop) return ended();
  *pass_ends_ += std::chrono::microseconds(recording_.duration_us);
  counters_.damaged += lost_by_pass_;
  return nothing_decodes(1);
}

Result<RecordingSource::Pair> RecordingSource::next_pair(const std::stop_token& stop) {
  const Instant begin = steady_clock::now();
  const std::uint64_t damaged_before = counters_.damaged;
  const std::size_t first = streams_[kDepth].next + 1;
  while (true) {
    const bool may_wait = recording_.sensor.has_color && !ended_ && synchronizer_.waiting() <= kDepthsAhead;
    if (auto pair = synchronizer_.take(may_wait)) return std::move(*pair);
    if (ended_) return ended();
    if (stop.stop_requested()) return asked_to_stop();
    if (!read_one()) {
      if (const auto end = end_pass(); !end) return fail(end.error());
    }
    const bool only_damage = counters_.damaged > damaged_before && !synchronizer_.has_depth();
    if (only_damage && steady_clock::now() - begin > kSignOfLife) return nothing_decodes(first);
  }
}

// The next pair that is shown. Returns at most kSignOfLife before the pair is due.
Result<RecordingSource::Pair> RecordingSource::next_shown(const std::stop_token& stop, Instant& due) {
  const Instant begin = steady_clock::now();
  while (!pending_) {
    auto pair = next_pair(stop);
    if (!pair) return fail(pair.error());
    if (const auto when = clock_.due(pair->timestamp_us)) {
      pending_ = std::move(*pair);
      pending_due_ = *when;
    } else if (steady_clock::now() - begin >= kSignOfLife) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("{}: skips to the instant that the other replays of its session show", path_));
    }
  }
  const Instant now = steady_clock::now();
  if (clock_.is_in_session() && pending_due_ - now > kSignOfLife) {
    wait_until(now + kSignOfLife, stop);
    if (stop.stop_requested()) return asked_to_stop();
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: its session has begun, but this camera's part of it has not", path_));
  }
  due = pending_due_;
  Pair pair = std::move(*pending_);
  pending_.reset();
  return pair;
}

Result<RgbdFrame> RecordingSource::next(std::stop_token stop) {
  if (!begun_) begun_ = steady_clock::now();
  if (pass_ends_) return wait_out(stop);
  const bool keeps_pace = settings_.pace == SourceSettings::Pace::kReal;
  Instant due{};
  auto pair = keeps_pace ? next_shown(stop, due) : next_pair(stop);
  if (!pair) return fail(pair.error());
  const Instant begin = steady_clock::now();
  RgbdFrame frame = std::move(*pair->depth);  // No other pair uses this depth picture.
  if (pair->color) {
    const Picture& color = *pair->color;
    frame.color = color->color;
    if (!pair->color_again) frame.durations.capture += color->durations.capture;
  }
  const Instant ready = steady_clock::now();
  frame.durations.capture += ready - begin;
  frame.metadata.captured_at = ready;
  if (keeps_pace) {
    wait_until(due, stop);
    if (stop.stop_requested()) return asked_to_stop();
    frame.metadata.captured_at = steady_clock::now();
  }
  frame.sensor_times = Synchronizer::times_of(*pair);
  frame.metadata.sequence = ++counters_.frames;
  frame.metadata.world_from_camera = recording_.sensor.world_from_camera.value_or(Rigid3{});
  if (recording_.sensor.has_color && !pair->same_instant) ++counters_.depth_without_color;
  return frame;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording(const std::string& path, const SourceSettings& settings) {
  auto reader = recording::OniReader::open(path);
  if (!reader) return fail(reader.error());
  const RecordedStream& depth = *reader->summary().find(RecordedStream::Kind::kDepth);
  if (auto plays = recording::check_playable(depth, path); !plays) return fail(plays.error());
  return std::make_unique<RecordingSource>(path, std::move(*reader), settings);
}

}  // namespace copresence::sensor
