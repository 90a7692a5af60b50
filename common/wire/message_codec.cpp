#include "common/wire/message_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/frame/bounds.h"
#include "common/text/excerpt.h"
#include "common/wire/byte_order.h"

namespace copresence::wire {
namespace {

// Sizes in bytes of the fixed parts of the bodies, as in docs/internals/wire_format.md.
constexpr std::size_t kHelloBytes = kMagic.size() + 4;
constexpr std::size_t kRejectBytes = 1 + 2;
constexpr std::size_t kWelcomeBytes = 8 + 8 + 8 * (4 + 8 + 9 + 3 + 2 + 1 + 2) + 8 + 2 + 2 + 2;
constexpr std::size_t kParameterBytes = 2 + 8;
constexpr std::size_t kTimeBytes = 8;
constexpr std::size_t kMaxWelcomeBytes =
    kWelcomeBytes + 2 * kMaxNameBytes + kMaxParameters * (kParameterBytes + kMaxNameBytes);
static_assert(kHelloBytes == 12 && kWelcomeBytes == 262 && kFrameHeadBytes == 96);

// Flags of a Welcome and of a frame.
constexpr std::uint8_t kHasColor = 1, kHasPose = 2, kIsTemporallyFiltered = 4;
constexpr std::uint32_t kKeyframe = 1;

struct SizeRange {
  std::size_t smallest = 0, largest = 0;
};

/// Sets the allowed sizes of a body of this type. Returns false for an unknown type.
bool size_range(std::uint8_t type, SizeRange& range) {
  switch (static_cast<MessageType>(type)) {
    case MessageType::kHello:
      range = {kHelloBytes, kHelloBytes};
      return true;
    case MessageType::kKeyframeRequest:
      range = {0, 0};
      return true;
    case MessageType::kFrameAck:
    case MessageType::kPing:
      range = {kTimeBytes, kTimeBytes};
      return true;
    case MessageType::kReject:
      range = {kRejectBytes, kRejectBytes + kMaxTextBytes};
      return true;
    case MessageType::kWelcome:
      range = {kWelcomeBytes, kMaxWelcomeBytes};
      return true;
    case MessageType::kFrame:
      range = {kFrameHeadBytes + 1, kMaxMessageBytes};
      return true;
    case MessageType::kEndOfStream:
    case MessageType::kCameraStatus:
      range = {2, 2 + kMaxTextBytes};
      return true;
    case MessageType::kPong:
      range = {2 * kTimeBytes, 2 * kTimeBytes};
      return true;
  }
  return false;
}

void write_header(ByteWriter& writer, MessageType type, std::size_t body_bytes) {
  writer.number(static_cast<std::uint32_t>(body_bytes));
  writer.number(static_cast<std::uint32_t>(type));
}

/// Builds a message whose body `write_body` writes.
template <class WriteBody>
Bytes message(MessageType type, const WriteBody& write_body) {
  Bytes body;
  ByteWriter to_body(body);
  write_body(to_body);
  Bytes bytes;
  bytes.reserve(kHeaderBytes + body.size());
  ByteWriter to(bytes);
  write_header(to, type, body.size());
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

std::uint64_t ticks(Instant instant) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count());
}

struct ReadInstant {
  Instant instant{};
  bool believable = false;
};

ReadInstant read_instant(ByteReader& reader) {
  const auto instant = instant_from_nanoseconds(reader.number<std::uint64_t>());
  return {instant.value_or(Instant{}), instant.has_value()};
}

/// Returns the number, but at most 2^32 - 1.
std::uint32_t in_32_bits(std::uint64_t number) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(number, std::numeric_limits<std::uint32_t>::max()));
}

std::uint32_t microseconds(Duration duration) {
  const auto count = std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
  return static_cast<std::uint32_t>(
      std::clamp<std::int64_t>(count, 0, std::numeric_limits<std::uint32_t>::max()));
}

Duration read_microseconds(ByteReader& reader) {
  return std::chrono::microseconds(reader.number<std::uint32_t>());
}

tl::unexpected<Error> corrupt(std::string what) {
  return fail(ErrorCode::kCorrupt, std::move(what));
}

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameBytes && text::is_printable(name);
}

bool is_known(PixelFormat format) {
  return format == PixelFormat::kGray8 || format == PixelFormat::kGray10 || format == PixelFormat::kYuv420 ||
         format == PixelFormat::kYuv444;
}

bool is_known(DepthUnit unit) {
  return unit == DepthUnit::k100Micrometres || unit == DepthUnit::kMillimetre;
}

}  // namespace

Bytes encode(const Hello& hello) {
  return message(MessageType::kHello, [&](ByteWriter& to) {
    for (const char c : kMagic) to.number(static_cast<std::uint8_t>(c));
    to.number(hello.version);
  });
}

Bytes encode(const Reject& reject) {
  return message(MessageType::kReject, [&](ByteWriter& to) {
    to.number(static_cast<std::uint8_t>(reject.reason));
    to.text(text::sanitise(reject.text, kMaxTextBytes));
  });
}

Bytes encode(const Welcome& welcome) {
  const StreamDescription& stream = welcome.description;
  assert(check(stream));
  return message(MessageType::kWelcome, [&](ByteWriter& to) {
    to.number(welcome.clock_id);
    to.number(ticks(welcome.server_time));
    for (const double value : {stream.model.fx, stream.model.fy, stream.model.cx, stream.model.cy})
      to.real(value);
    for (const double k : stream.model.distortion) to.real(k);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) to.real(stream.world_from_camera.rotation(row, column));
    }
    for (int row = 0; row < 3; ++row) to.real(stream.world_from_camera.translation(row));
    for (const double value : {stream.range.near_m, stream.range.far_m, stream.frames_per_second,
                               stream.noise.disparity_constant_m, stream.noise.sigma_steps})
      to.real(value);
    to.number(static_cast<std::uint16_t>(stream.model.width));
    to.number(static_cast<std::uint16_t>(stream.model.height));
    to.number(static_cast<std::uint16_t>(stream.unit));
    to.number(static_cast<std::uint8_t>((stream.has_color ? kHasColor : 0) |
                                        (stream.has_pose ? kHasPose : 0) |
                                        (stream.is_temporally_filtered ? kIsTemporallyFiltered : 0)));
    to.number(static_cast<std::uint8_t>(stream.codec.format));
    to.text(stream.camera);
    to.text(stream.codec.name);
    to.number(static_cast<std::uint16_t>(stream.codec.parameters.size()));
    for (const auto& [name, value] : stream.codec.parameters) {
      to.text(name);
      to.real(value);
    }
  });
}

Bytes encode(const EndOfStream& end) {
  return message(MessageType::kEndOfStream,
                 [&](ByteWriter& to) { to.text(text::sanitise(end.reason, kMaxTextBytes)); });
}

Bytes encode(const CameraStatus& status) {
  return message(MessageType::kCameraStatus,
                 [&](ByteWriter& to) { to.text(text::sanitise(status.text, kMaxTextBytes)); });
}

Bytes encode(const FrameAck& ack) {
  return message(MessageType::kFrameAck, [&](ByteWriter& to) { to.number(ack.sequence); });
}

Bytes encode(const Ping& ping) {
  return message(MessageType::kPing, [&](ByteWriter& to) { to.number(ticks(ping.client_time)); });
}

Bytes encode(const Pong& pong) {
  return message(MessageType::kPong, [&](ByteWriter& to) {
    to.number(ticks(pong.client_time));
    to.number(ticks(pong.server_time));
  });
}

Bytes encode_keyframe_request() {
  return message(MessageType::kKeyframeRequest, [](ByteWriter&) {});
}

FrameHeadMessage encode(const FrameHead& head) {
  const std::size_t body_bytes = kFrameHeadBytes + std::size_t{head.depth_bytes} + head.color_bytes;
  assert(head.sequence > 0 && head.depth_bytes > 0 && body_bytes <= kMaxMessageBytes);
  Bytes bytes;
  bytes.reserve(kHeaderBytes + kFrameHeadBytes);
  ByteWriter to(bytes);
  write_header(to, MessageType::kFrame, body_bytes);
  to.number(head.sequence);
  to.number(ticks(head.sent_at));
  to.number(head.counters.captured);
  to.number(head.counters.encoder_busy);
  to.number(head.counters.window_full);
  const StageDurations& took = head.durations;
  for (const Duration stage : {took.capture, took.fill, took.depth_encode, took.video_encode}) {
    to.number(microseconds(stage));
  }
  to.number(head.keyframe ? kKeyframe : 0u);
  to.number(head.depth_bytes);
  to.number(head.counters.depth_without_color);
  to.number(head.counters.color_without_depth);
  to.number(in_32_bits(head.counters.damaged));
  to.number(in_32_bits(head.counters.late));
  to.number(head.counters.dark);
  FrameHeadMessage out;
  assert(bytes.size() == out.size());
  std::copy(bytes.begin(), bytes.end(), out.begin());
  return out;
}

Result<MessageHeader> decode_header(std::span<const std::uint8_t, kHeaderBytes> bytes) {
  ByteReader from(bytes);
  const auto body_bytes = from.number<std::uint32_t>();
  const auto type = from.number<std::uint32_t>();
  SizeRange range;
  if (type > 255 || !size_range(static_cast<std::uint8_t>(type), range)) {
    return corrupt(fmt::format("a message of unknown type {}", type));
  }
  if (body_bytes < range.smallest || body_bytes > range.largest) {
    return corrupt(fmt::format("a message of type {} cannot have {} bytes", type, body_bytes));
  }
  return MessageHeader{static_cast<MessageType>(type), body_bytes};
}

Result<Hello> decode_hello(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  bool magic = true;
  for (const char c : kMagic) magic &= from.number<std::uint8_t>() == static_cast<std::uint8_t>(c);
  const Hello hello{from.number<std::uint32_t>()};
  if (!magic || !from.complete()) return corrupt("a hello of no render_client");
  return hello;
}

Result<Reject> decode_reject(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  const auto reason = static_cast<RejectReason>(from.number<std::uint8_t>());
  Reject reject{reason, from.text()};
  if (!from.complete() || reject.text.size() > kMaxTextBytes || !text::is_printable(reject.text)) {
    return corrupt("a reject message that cannot be read");
  }
  return reject;
}

Result<Welcome> decode_welcome(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  Welcome welcome;
  StreamDescription& stream = welcome.description;
  welcome.clock_id = from.number<std::uint64_t>();
  const ReadInstant server_time = read_instant(from);
  welcome.server_time = server_time.instant;
  for (double* value : {&stream.model.fx, &stream.model.fy, &stream.model.cx, &stream.model.cy})
    *value = from.real();
  for (double& k : stream.model.distortion) k = from.real();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) stream.world_from_camera.rotation(row, column) = from.real();
  }
  for (int row = 0; row < 3; ++row) stream.world_from_camera.translation(row) = from.real();
  for (double* value : {&stream.range.near_m, &stream.range.far_m, &stream.frames_per_second,
                        &stream.noise.disparity_constant_m, &stream.noise.sigma_steps})
    *value = from.real();
  stream.model.width = from.number<std::uint16_t>();
  stream.model.height = from.number<std::uint16_t>();
  stream.unit = static_cast<DepthUnit>(from.number<std::uint16_t>());
  const auto flags = from.number<std::uint8_t>();
  stream.has_color = flags & kHasColor;
  stream.has_pose = flags & kHasPose;
  stream.is_temporally_filtered = flags & kIsTemporallyFiltered;
  stream.codec.format = static_cast<PixelFormat>(from.number<std::uint8_t>());
  stream.camera = from.text();
  stream.codec.name = from.text();
  const std::size_t parameters = from.number<std::uint16_t>();
  if (parameters > kMaxParameters) return corrupt(fmt::format("a codec with {} parameters", parameters));
  for (std::size_t i = 0; i < parameters && from.ok(); ++i) {
    std::string name = from.text();
    stream.codec.parameters.emplace_back(std::move(name), from.real());
  }
  if (!from.complete() || !server_time.believable ||
      flags & ~(kHasColor | kHasPose | kIsTemporallyFiltered)) {
    return corrupt("a description of the stream that cannot be read");
  }
  if (const auto good = check(stream); !good) return corrupt(good.error().what);
  return welcome;
}

Result<EndOfStream> decode_end_of_stream(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  EndOfStream end{from.text()};
  if (!from.complete() || end.reason.size() > kMaxTextBytes || !text::is_printable(end.reason)) {
    return corrupt("an end of stream that cannot be read");
  }
  return end;
}

Result<CameraStatus> decode_camera_status(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  CameraStatus status{from.text()};
  if (!from.complete() || status.text.size() > kMaxTextBytes || !text::is_printable(status.text)) {
    return corrupt("a camera status that cannot be read");
  }
  return status;
}

Result<FrameAck> decode_frame_ack(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  const FrameAck ack{from.number<std::uint64_t>()};
  if (!from.complete()) return corrupt("an acknowledgement of the wrong size");
  return ack;
}

Result<Ping> decode_ping(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  const ReadInstant client = read_instant(from);
  if (!from.complete() || !client.believable) return corrupt("a ping at an impossible time");
  return Ping{client.instant};
}

Result<Pong> decode_pong(std::span<const std::uint8_t> body) {
  ByteReader from(body);
  const ReadInstant client = read_instant(from);
  const ReadInstant server = read_instant(from);
  if (!from.complete() || !client.believable || !server.believable)
    return corrupt("a pong at an impossible time");
  return Pong{client.instant, server.instant};
}

Result<FrameHead> decode_frame_head(std::span<const std::uint8_t, kFrameHeadBytes> bytes,
                                    std::uint32_t body_bytes) {
  assert(body_bytes >= kFrameHeadBytes);
  ByteReader from(bytes);
  FrameHead head;
  head.sequence = from.number<std::uint64_t>();
  const ReadInstant sent_at = read_instant(from);
  head.sent_at = sent_at.instant;
  head.counters.captured = from.number<std::uint64_t>();
  head.counters.encoder_busy = from.number<std::uint64_t>();
  head.counters.window_full = from.number<std::uint64_t>();
  StageDurations& took = head.durations;
  for (Duration* stage : {&took.capture, &took.fill, &took.depth_encode, &took.video_encode}) {
    *stage = read_microseconds(from);
  }
  const auto flags = from.number<std::uint32_t>();
  head.keyframe = flags & kKeyframe;
  head.depth_bytes = from.number<std::uint32_t>();
  head.counters.depth_without_color = from.number<std::uint64_t>();
  head.counters.color_without_depth = from.number<std::uint64_t>();
  head.counters.damaged = from.number<std::uint32_t>();
  head.counters.late = from.number<std::uint32_t>();
  head.counters.dark = from.number<std::uint64_t>();
  const std::size_t access_units = body_bytes - kFrameHeadBytes;
  const FrameCounters& counted = head.counters;
  for (const std::uint64_t number :
       {head.sequence, counted.captured, counted.encoder_busy, counted.window_full,
        counted.depth_without_color, counted.color_without_depth, counted.damaged, counted.dark}) {
    if (!is_within_bounds(number)) return corrupt("a frame with an impossible counter");
  }
  if (head.sequence == 0 || !sent_at.believable || flags & ~kKeyframe || head.depth_bytes == 0 ||
      head.depth_bytes > access_units) {
    return corrupt("a frame whose head contradicts itself");
  }
  head.color_bytes = static_cast<std::uint32_t>(access_units - head.depth_bytes);
  return head;
}

Result<void> check(const StreamDescription& stream) {
  const auto invalid = [](std::string what) { return fail(ErrorCode::kInvalid, std::move(what)); };
  if (!is_name(stream.camera)) {
    return invalid(fmt::format("a camera's name must have 1 to {} printable bytes", kMaxNameBytes));
  }
  if (const auto camera = check(stream.model); !camera) return camera;
  if (!is_known(stream.unit)) return invalid("a stream's depth unit must be 0.1 mm or 1 mm");
  const DepthRange& range = stream.range;
  if (!(range.near_m >= 1e-3 && range.far_m - range.near_m >= 1e-3 && range.far_m <= 100)) {
    return invalid("a stream's depth range must be NEAR:FAR in metres with 0.001 <= NEAR < FAR <= 100");
  }
  if (!(stream.frames_per_second >= 0.1 && stream.frames_per_second <= 1000)) {
    return invalid("a stream's rate must lie between 0.1 and 1000 frames per second");
  }
  if (const auto pose = check_pose(stream.world_from_camera); !pose) return pose;
  if (const auto noise = check_noise(stream.noise); !noise) return noise;
  if (!is_known(stream.codec.format)) return invalid("a depth codec's pictures have no known pixel format");
  if (!is_name(stream.codec.name)) return invalid("a depth codec without a printable name");
  const auto& parameters = stream.codec.parameters;
  const bool sound = std::all_of(parameters.begin(), parameters.end(), [](const auto& parameter) {
    return is_name(parameter.first) && std::isfinite(parameter.second);
  });
  if (!sound || parameters.size() > kMaxParameters) {
    return invalid(fmt::format("a depth codec has at most {} parameters, named and finite", kMaxParameters));
  }
  return {};
}

}  // namespace copresence::wire
