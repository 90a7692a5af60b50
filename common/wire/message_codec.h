#pragma once

// Encodes messages to bytes and decodes them. The web gateway and the page use it, too.
//
// The peer is not trusted. Decoding checks every length before it allocates memory, and every
// enumerator, number and text. A decoded message needs no further checks. All decode functions fail
// with kCorrupt. Thread: pure functions.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/wire/message.h"

namespace copresence::wire {

using Bytes = std::vector<std::uint8_t>;
using FrameHeadMessage = std::array<std::uint8_t, kHeaderBytes + kFrameHeadBytes>;

/// Encodes a whole message, header and body. Texts are sanitised and cut to kMaxTextBytes. Welcome
/// requires a description that passes check().
Bytes encode(const Hello& message);
Bytes encode(const Reject& message);
Bytes encode(const Welcome& message);
Bytes encode(const EndOfStream& message);
Bytes encode(const CameraStatus& message);
Bytes encode(const FrameAck& message);
Bytes encode(const Ping& message);
Bytes encode(const Pong& message);
Bytes encode_keyframe_request();

/// Encodes the header and the head of a frame message. The access units must follow. Requires
/// sequence and depth_bytes of at least 1 and a body of at most kMaxMessageBytes.
FrameHeadMessage encode(const FrameHead& head);

/// Fails for unknown types, and for sizes that a message of this type cannot have.
Result<MessageHeader> decode_header(std::span<const std::uint8_t, kHeaderBytes> bytes);

/// Decode the body of a message. `body` must have the length given in the header.
Result<Hello> decode_hello(std::span<const std::uint8_t> body);
Result<Reject> decode_reject(std::span<const std::uint8_t> body);
Result<Welcome> decode_welcome(std::span<const std::uint8_t> body);
Result<EndOfStream> decode_end_of_stream(std::span<const std::uint8_t> body);
Result<CameraStatus> decode_camera_status(std::span<const std::uint8_t> body);
Result<FrameAck> decode_frame_ack(std::span<const std::uint8_t> body);
Result<Ping> decode_ping(std::span<const std::uint8_t> body);
Result<Pong> decode_pong(std::span<const std::uint8_t> body);

/// Decodes the head of a frame, the first bytes of a body of `body_bytes`.
Result<FrameHead> decode_frame_head(std::span<const std::uint8_t, kFrameHeadBytes> head,
                                    std::uint32_t body_bytes);

/// Checks a description before it is sent and after it was received. Fails with kInvalid if camera
/// model, pose or noise fail check(), check_pose() or check_noise(). Requires 1 mm <= near, near +
/// 1 mm <= far <= 100 m, and 0.1 <= frames per second <= 1000. Requires finite codec parameters,
/// and names of 1 to kMaxNameBytes printable UTF-8 bytes.
Result<void> check(const StreamDescription& description);

}  // namespace copresence::wire
