#pragma once

// Messages to bytes and back. Pure: no sockets, no clocks.
//
// What is decoded came from a stranger: every length is checked before anything is allocated, every
// enumerator, number and text before it is handed on. What passes can be used without further checks. All
// decode functions fail with kCorrupt and a sentence.
//
// Thread: pure functions.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/wire/message.h"

namespace copresence::wire {

using Bytes = std::vector<std::uint8_t>;
using FrameHeadMessage = std::array<std::uint8_t, kHeaderBytes + kFrameHeadBytes>;

/// A whole message, header and body. Texts are shortened to kMaxTextBytes and made printable.
/// Welcome requires a description that passes check().
Bytes encode(const Hello& message);
Bytes encode(const Reject& message);
Bytes encode(const Welcome& message);
Bytes encode(const EndOfStream& message);
Bytes encode(const CameraStatus& message);
Bytes encode(const FrameAck& message);
Bytes encode(const Ping& message);
Bytes encode(const Pong& message);
Bytes encode_keyframe_request();

/// Header and head of a frame message, to be followed by the access units as they are.
/// Requires sequence and depth_bytes at least 1 and a body of at most kMaxMessageBytes.
FrameHeadMessage encode(const FrameHead& head);

/// Fails for types nobody knows and for sizes that a message of this type cannot have.
Result<MessageHeader> decode_header(std::span<const std::uint8_t, kHeaderBytes> bytes);

/// One body each, exactly as long as its header said.
Result<Hello> decode_hello(std::span<const std::uint8_t> body);
Result<Reject> decode_reject(std::span<const std::uint8_t> body);
Result<Welcome> decode_welcome(std::span<const std::uint8_t> body);
Result<EndOfStream> decode_end_of_stream(std::span<const std::uint8_t> body);
Result<CameraStatus> decode_camera_status(std::span<const std::uint8_t> body);
Result<FrameAck> decode_frame_ack(std::span<const std::uint8_t> body);
Result<Ping> decode_ping(std::span<const std::uint8_t> body);
Result<Pong> decode_pong(std::span<const std::uint8_t> body);

/// The head of a frame whose body has `body_bytes`; `head` is its beginning.
Result<FrameHead> decode_frame_head(std::span<const std::uint8_t, kFrameHeadBytes> head,
                                    std::uint32_t body_bytes);

/// What a stream's description must satisfy to be sent and to be believed: a camera model that passes
/// copresence::check(), a pose that passes check_pose(), a noise that passes check_noise(), 1 mm <= near, near + 1 mm <= far <= 100 m, 0.1 <= frames per second
/// <= 1000, finite codec parameters, names of 1 to kMaxNameBytes printable UTF-8 bytes. Fails with kInvalid.
Result<void> check(const StreamDescription& description);

}  // namespace copresence::wire
