// Messages of the wire and the clock of the gateway, for the worker that owns the connection.

#include <cassert>

#include "common/wire/clock_offset.h"
#include "common/wire/message_codec.h"
#include "web/native/exports.h"

namespace copresence::web {
namespace {

using wire::MessageType;

JsonObject describe(const wire::FrameHead& head) {
  const wire::FrameCounters& counters = head.counters;
  JsonObject out;
  out.add("type", "frame")
      .add("sequence", static_cast<double>(head.sequence))
      .add("keyframe", head.keyframe)
      .add("sentAt", microseconds(head.sent_at))
      .add("counters", JsonObject()
                           .add("captured", static_cast<double>(counters.captured))
                           .add("encoder_busy", static_cast<double>(counters.encoder_busy))
                           .add("window_full", static_cast<double>(counters.window_full)))
      .add("stages", JsonObject()
                         .add("capture", microseconds(head.durations.capture))
                         .add("fill", microseconds(head.durations.fill))
                         .add("depth_encode", microseconds(head.durations.depth_encode))
                         .add("video_encode", microseconds(head.durations.video_encode)));
  return out;
}

// Describes a message of which the first bytes are enough: `bytes` may lack a frame's access units.
Result<JsonObject> describe(std::span<const std::uint8_t> bytes) {
  const auto cut = [] { return fail(ErrorCode::kCorrupt, "a message that is cut"); };
  if (bytes.size() < wire::kHeaderBytes) return cut();
  const auto header = wire::decode_header(bytes.first<wire::kHeaderBytes>());
  if (!header) return fail(header.error());
  const auto rest = bytes.subspan(wire::kHeaderBytes);
  if (header->type == MessageType::kFrame) {
    if (rest.size() < wire::kFrameHeadBytes) return cut();
    const auto head = wire::decode_frame_head(rest.first<wire::kFrameHeadBytes>(), header->body_bytes);
    if (!head) return fail(head.error());
    return describe(*head);
  }
  if (rest.size() != header->body_bytes) return cut();
  switch (header->type) {
    case MessageType::kWelcome: {
      const auto welcome = wire::decode_welcome(rest);
      if (!welcome) return fail(welcome.error());
      return JsonObject().add("type", "welcome");
    }
    case MessageType::kCameraStatus: {
      const auto status = wire::decode_camera_status(rest);
      if (!status) return fail(status.error());
      return JsonObject().add("type", "status").add("text", status->text);
    }
    case MessageType::kEndOfStream: {
      const auto end = wire::decode_end_of_stream(rest);
      if (!end) return fail(end.error());
      return JsonObject().add("type", "end").add("text", end->reason).add("final", end->is_final());
    }
    case MessageType::kPong: {
      const auto pong = wire::decode_pong(rest);
      if (!pong) return fail(pong.error());
      return JsonObject()
          .add("type", "pong")
          .add("clientTime", microseconds(pong->client_time))
          .add("serverTime", microseconds(pong->server_time));
    }
    default:
      return fail(ErrorCode::kCorrupt, "a message that no server sends to a viewer");
  }
}

wire::ClockEstimate& gateway_clock() {
  static wire::ClockEstimate estimate;
  return estimate;
}

}  // namespace

COPRESENCE_EXPORT(describe_message) int describe_message(std::uint32_t bytes) {
  const auto described = describe(input(bytes));
  return described ? succeed(*described) : fail_with(described.error());
}

COPRESENCE_EXPORT(write_frame_ack) int write_frame_ack(double sequence) {
  return succeed(wire::encode(wire::FrameAck{static_cast<std::uint64_t>(sequence)}));
}

COPRESENCE_EXPORT(write_keyframe_request) int write_keyframe_request() {
  return succeed(wire::encode_keyframe_request());
}

COPRESENCE_EXPORT(write_ping) int write_ping(double now) {
  return succeed(wire::encode(wire::Ping{instant_of(now)}));
}

// Adds the answer to a ping and describes the gateway's clock: "offset" is the gateway's time minus
// the page's.
COPRESENCE_EXPORT(add_pong) int add_pong(double sent, double gateway_time, double received) {
  gateway_clock().add(instant_of(sent), instant_of(gateway_time), instant_of(received));
  const wire::ClockOffset clock = gateway_clock().at(instant_of(received));
  return succeed(JsonObject()
                     .add("offset", microseconds(clock.offset))
                     .add("uncertainty", microseconds(clock.uncertainty)));
}

}  // namespace copresence::web
