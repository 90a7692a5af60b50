#include "render_client/session/playback.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include "common/bitstream/side_data.h"
#include "common/wire/message.h"

namespace copresence::session {
namespace {

constexpr std::string_view kStreamChanges = "its stream changes";

/// Returns the number of the stream's frames up to `time`.
std::size_t frames_until(const RecordedStream& stream, Time time) {
  const auto after = std::upper_bound(stream.frames.begin(), stream.frames.end(), time,
                                      [](Time t, const RecordedFrame& frame) { return t < frame.time(); });
  return static_cast<std::size_t>(after - stream.frames.begin());
}

Error stopped() {
  return {ErrorCode::kUnavailable, "the replay was asked to stop"};
}

}  // namespace

class Playback::Source final : public stream::FrameSource {
 public:
  Source(Playback& playback, std::size_t camera, std::size_t stream)
      : playback_(playback),
        camera_(camera),
        stream_(stream),
        recorded_(playback.file_.cameras()[camera].streams[stream]) {}

  const StreamDescription& description() const override { return recorded_.description; }

  Result<wire::ReceivedFrame> next(std::stop_token stop, std::optional<Instant> latest) override {
    const RecordedFrame* recorded = nullptr;
    {
      std::unique_lock lock(playback_.mutex_);
      Cursor& cursor = playback_.cursors_[camera_];
      const bool is_due = playback_.wait_until_due(lock, camera_, stream_, stop, latest);
      if (cursor.stream != stream_) return fail(end(cursor));
      if (!is_due && stop.stop_requested()) return fail(stopped());
      if (!is_due) return fail(ErrorCode::kTimeout, "no frame of the recording is due");
      recorded = &recorded_.frames[cursor.frame++];
      if (cursor.frame == recorded_.frames.size()) {
        ++cursor.stream;
        cursor.frame = 0;
      }
    }
    wire::ReceivedFrame received;
    auto encoded = playback_.file_.read(*recorded);
    if (!encoded) return fail(encoded.error());
    received.frame = std::move(*encoded);
    received.received_at = instant(recorded->time());
    // The capture time inside the frame is on the server's clock. The recording has it on the
    // recorder's clock, so the difference is the offset between the clocks. A damaged frame has no
    // capture time; it cannot be decoded either.
    if (const auto data = bitstream::extract_side_data(received.frame.depth, received.frame.color)) {
      received.frame.sequence = data->sequence;
      received.sent_at = data->captured_at;
      clock_.offset = data->captured_at - received.received_at;
    }
    ++counters_.captured;
    received.counters = counters_;
    return received;
  }

  /// Does nothing: a recording cannot make keyframes.
  void request_keyframe() override {}
  wire::ClockOffset clock() const override { return clock_; }
  /// A recording has no status.
  void on_status(std::function<void(const std::string&)>) override {}

 private:
  Error end(const Cursor& cursor) const {
    const bool is_over = cursor.stream == playback_.file_.cameras()[camera_].streams.size();
    return {ErrorCode::kEndOfStream, std::string(is_over ? wire::kRecordingIsOver : kStreamChanges)};
  }

  Playback& playback_;
  std::size_t camera_, stream_;
  const RecordedStream& recorded_;
  wire::ClockOffset clock_;
  wire::FrameCounters counters_;
};

Playback::Playback(SessionFile file)
    : file_(std::move(file)), position_(file_.begin() - Time(1)), cursors_(file_.cameras().size()) {}

Instant Playback::now() const {
  std::lock_guard lock(mutex_);
  return instant(position_);
}

void Playback::advance(Time position) {
  {
    std::lock_guard lock(mutex_);
    position_ = position;
  }
  changed_.notify_all();
}

void Playback::seek(Time position) {
  {
    std::lock_guard lock(mutex_);
    for (std::size_t camera = 0; camera < cursors_.size(); ++camera) {
      const auto& streams = file_.cameras()[camera].streams;
      std::size_t stream = streams.size() - 1;
      while (stream > 0 && streams[stream].begin() > position) --stream;
      std::size_t frame = frames_until(streams[stream], position);
      frame = frame == 0 ? 0 : frame - 1;
      while (frame > 0 && !streams[stream].frames[frame].is_keyframe()) --frame;
      // A jump forward within a group of pictures continues with the next frame.
      Cursor& cursor = cursors_[camera];
      const bool is_on_the_way = position >= position_ && cursor.stream == stream && cursor.frame >= frame;
      if (is_on_the_way) continue;
      cursor.stream = stream;
      cursor.frame = frame;
    }
    position_ = position;
  }
  changed_.notify_all();
}

void Playback::wait_until_taken(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return all_taken(); });
}

std::optional<Time> Playback::next_frame_after(Time time) const {
  std::optional<Time> next;
  for (const RecordedCamera& camera : file_.cameras()) {
    for (const RecordedStream& stream : camera.streams) {
      const std::size_t index = frames_until(stream, time);
      if (index == stream.frames.size()) continue;
      const Time found = stream.frames[index].time();
      next = std::min(next.value_or(found), found);
      break;
    }
  }
  return next;
}

Result<std::unique_ptr<stream::FrameSource>> Playback::connect(std::size_t camera, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  if (!wait_until_due(lock, camera, std::nullopt, std::move(stop), std::nullopt)) return fail(stopped());
  return std::make_unique<Source>(*this, camera, cursors_[camera].stream);
}

bool Playback::wait_until_due(std::unique_lock<std::mutex>& lock, std::size_t camera,
                              std::optional<std::size_t> stream, std::stop_token stop,
                              std::optional<Instant> latest) {
  Cursor& cursor = cursors_[camera];
  const auto is_over = [&] { return is_due(camera) || (stream && cursor.stream != *stream); };
  if (!is_over()) {
    cursor.is_waiting = true;
    changed_.notify_all();
    if (latest) {
      changed_.wait_until(lock, stop, *latest, is_over);
    } else {
      changed_.wait(lock, stop, is_over);
    }
    cursor.is_waiting = false;
  }
  return is_due(camera) && !stop.stop_requested();
}

std::optional<Time> Playback::next_time(std::size_t camera) const {
  const auto& streams = file_.cameras()[camera].streams;
  const Cursor& cursor = cursors_[camera];
  if (cursor.stream == streams.size()) return std::nullopt;
  return streams[cursor.stream].frames[cursor.frame].time();
}

bool Playback::is_due(std::size_t camera) const {
  const auto time = next_time(camera);
  return time && *time <= position_;
}

bool Playback::all_taken() const {
  for (std::size_t camera = 0; camera < cursors_.size(); ++camera) {
    if (!cursors_[camera].is_waiting || is_due(camera)) return false;
  }
  return true;
}

}  // namespace copresence::session
