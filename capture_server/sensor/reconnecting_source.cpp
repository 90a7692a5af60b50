#include "capture_server/sensor/reconnecting_source.h"

#include <fmt/format.h>

#include "common/flow/waiting.h"

namespace copresence::sensor {
namespace {

SourceCounters sum(const SourceCounters& a, const SourceCounters& b) {
  return {a.frames + b.frames,
          a.depth_without_color + b.depth_without_color,
          a.color_without_depth + b.color_without_depth,
          a.damaged + b.damaged,
          a.late + b.late,
          a.projector_off + b.projector_off};
}

bool may_pass(const Error& error) {
  return error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kTimeout ||
         error.code == ErrorCode::kNotFound;
}

// True if frames of both sources fit into one stream with one description.
bool same_stream(const SensorDescription& a, const SensorDescription& b) {
  const auto same_size = [](const CameraModel& x, const CameraModel& y) {
    return x.width == y.width && x.height == y.height;
  };
  return same_size(a.depth, b.depth) && a.unit == b.unit && a.has_color == b.has_color &&
         a.registered == b.registered && (!a.has_color || same_size(a.color, b.color));
}

}  // namespace

Result<std::unique_ptr<FrameSource>> ReconnectingSource::open(Open open,
                                                              std::chrono::milliseconds between_tries) {
  auto first = open();
  if (!first) return fail(first.error());
  return std::unique_ptr<FrameSource>(
      new ReconnectingSource(std::move(*first), std::move(open), between_tries));
}

ReconnectingSource::ReconnectingSource(std::unique_ptr<FrameSource> first, Open open,
                                       std::chrono::milliseconds between_tries)
    : open_(std::move(open)),
      between_tries_(between_tries),
      description_(first->description()),
      source_(std::move(first)) {}

SourceCounters ReconnectingSource::counters() const {
  return source_ ? sum(before_, source_->counters()) : before_;
}

Result<RgbdFrame> ReconnectingSource::next(std::stop_token stop) {
  if (!source_) {
    wait_for(between_tries_, stop);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    auto again = open_();
    if (!again)
      return fail(may_pass(again.error()) ? ErrorCode::kUnavailable : again.error().code, again.error().what);
    if (!same_stream((*again)->description(), description_)) {
      return fail(ErrorCode::kUnsupported,
                  fmt::format("{}: a different kind of camera was plugged in ({}); start the server again",
                              description_.name, (*again)->description().name));
    }
    source_ = std::move(*again);
  }
  auto frame = source_->next(stop);
  if (frame) {
    frame->metadata.sequence += before_.frames;
    return frame;
  }
  if (may_pass(frame.error())) {
    before_ = sum(before_, source_->counters());
    source_.reset();
  }
  return frame;
}

}  // namespace copresence::sensor
