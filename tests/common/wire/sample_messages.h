#pragma once

// One message of each kind, as docs/internals/wire_format.md shows them. Their numbers are easy to
// recognise in hexadecimal.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/wire/message_codec.h"

namespace copresence::wire {

inline Instant at_ns(std::int64_t nanoseconds) {
  return Instant(std::chrono::nanoseconds(nanoseconds));
}

inline StreamDescription sample_description() {
  StreamDescription stream;
  stream.camera = "left";
  stream.model = {640, 480, 585, 586, 320, 240, {0.5, -0.25, 0, 0, 0, 0, 0, 0}};
  stream.unit = DepthUnit::k100Micrometres;
  stream.range = {0.5, 4};
  stream.frames_per_second = 30;
  stream.has_color = true;
  stream.has_pose = true;
  stream.is_temporally_filtered = true;
  stream.world_from_camera.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  stream.world_from_camera.translation << 1, 2, -3;
  stream.codec = {"quantized", PixelFormat::kGray10, {{"levels", 1024}}};
  return stream;
}

inline Welcome sample_welcome() {
  return {0x1122334455667788, at_ns(5'000'000'000), sample_description()};
}

inline FrameHead sample_frame_head() {
  using std::chrono::microseconds;
  FrameHead head;
  head.keyframe = true;
  head.sequence = 300;
  head.sent_at = at_ns(10'000'000'000);
  head.counters = {301, 4, 2, 5, 6, 7, 9, 8};
  head.durations = {microseconds(100), microseconds(1500), microseconds(800), microseconds(6000)};
  head.depth_bytes = 80;
  head.color_bytes = 20;
  return head;
}

/// The names are those in docs/internals/wire_format.md. `frame` contains only a frame's head.
inline std::vector<std::pair<std::string, Bytes>> sample_messages() {
  const FrameHeadMessage frame = encode(sample_frame_head());
  return {
      {"hello", encode(Hello{})},
      {"reject", encode(Reject{RejectReason::kFull, "full"})},
      {"welcome", encode(sample_welcome())},
      {"frame", Bytes(frame.begin(), frame.end())},
      {"end of stream", encode(EndOfStream{"the end"})},
      {"camera status", encode(CameraStatus{"unplugged"})},
      {"keyframe request", encode_keyframe_request()},
      {"frame ack", encode(FrameAck{300})},
      {"ping", encode(Ping{at_ns(1'000'000'000)})},
      {"pong", encode(Pong{at_ns(1'000'000'000), at_ns(5'000'000'000)})},
  };
}

}  // namespace copresence::wire
