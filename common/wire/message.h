#pragma once

// The messages between client and server. See docs/internals/wire_format.md for their bytes. A test
// compares that page with message_codec.h.
//
// A message is a header of 8 bytes and a body. Numbers are little-endian. The client sends Hello.
// The server answers with a Reject, or with a Welcome and then frames. The client acknowledges each
// frame. Hello and Reject have the same layout in every version, so that different releases can
// recognise each other. Thread: distinct objects are independent.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"

namespace copresence::wire {

/// Client and server must have the same version. Increase this number with every change of the
/// format.
inline constexpr std::uint32_t kProtocolVersion = 7;
inline constexpr std::array<char, 8> kMagic = {'C', 'O', 'P', 'R', 'E', 'S', 'N', 'C'};

inline constexpr std::size_t kHeaderBytes = 8;
inline constexpr std::size_t kFrameHeadBytes = 96;  ///< Part of a frame's body before its access units.
inline constexpr std::size_t kMaxMessageBytes =
    8 * 1024 * 1024;                               ///< Largest body of a message, that of a frame.
inline constexpr std::size_t kMaxTextBytes = 512;  ///< Longest sentence for the user, in UTF-8.
inline constexpr std::size_t kMaxNameBytes = 64;   ///< Longest name of a camera, codec or parameter.
inline constexpr std::size_t kMaxParameters = 64;  ///< Largest number of parameters of a depth codec.

enum class MessageType : std::uint8_t {
  kHello = 1,            ///< Client: the first message.
  kKeyframeRequest = 2,  ///< Client: it cannot decode the next frames without a keyframe.
  kFrameAck = 3,         ///< Client: it has this frame and all earlier frames.
  kPing = 4,             ///< Client: it asks for the time of the server's clock.
  kReject = 17,          ///< Server: sent instead of Welcome as the last message.
  kWelcome = 18,         ///< Server: describes the stream.
  kFrame = 19,           ///< Server: one EncodedFrame.
  kEndOfStream = 20,     ///< Server: the last message.
  kPong = 21,            ///< Server: the answer to a Ping.
  kCameraStatus = 22,    ///< Server: the status of its camera has changed.
};

struct MessageHeader {
  MessageType type{};
  std::uint32_t body_bytes = 0;
  friend bool operator==(const MessageHeader&, const MessageHeader&) = default;
};

struct Hello {
  std::uint32_t version = kProtocolVersion;
  friend bool operator==(const Hello&, const Hello&) = default;
};

enum class RejectReason : std::uint8_t {
  kVersion = 1,        ///< The version differs.
  kFull = 2,           ///< The server is full.
  kKeyNeeded = 3,      ///< The client does not encrypt, and the server has a room key.
  kKeyUnexpected = 4,  ///< The client encrypts, and the server has no room key.
};

/// True if connecting again later may help. A reason that this release does not know is final.
constexpr bool may_pass(RejectReason reason) {
  return reason == RejectReason::kFull;
}

struct Reject {
  RejectReason reason = RejectReason::kVersion;
  std::string text;  ///< One sentence.
  friend bool operator==(const Reject&, const Reject&) = default;
};

struct Welcome {
  std::uint64_t clock_id = 0;  ///< Value of monotonic_clock_id() on the server; 0 if unknown.
  Instant server_time{};       ///< When this message was encoded.
  StreamDescription description;
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

/// Counts the frames since the start of the stream by what happened to them. If a client received
/// frame b directly after frame a, then b.sequence - a.sequence - 1 is the increase of encoder_busy
/// plus that of window_full.
struct FrameCounters {
  std::uint64_t captured = 0;      ///< Frames from the sensor.
  std::uint64_t encoder_busy = 0;  ///< Frames not encoded because the encoder was busy.
  std::uint64_t window_full = 0;   ///< Frames not sent because the client's window was full.

  // The next counters count the sensor's pictures.
  std::uint64_t depth_without_color = 0;  ///< Frames with an older colour picture, or with none.
  std::uint64_t color_without_depth = 0;  ///< Colour pictures that are in no frame.
  std::uint64_t damaged = 0;              ///< Pictures that could not be decoded, or that a recording lacks.
  std::uint64_t late = 0;                 ///< Pictures replaced by a newer picture before use.
  std::uint64_t dark = 0;                 ///< Depth pictures left out, since the projector was off.
  // `damaged` and `late` are sent in 32 bits each. Larger values are sent as 2^32 - 1.
  friend bool operator==(const FrameCounters&, const FrameCounters&) = default;
};

/// The head of a frame. The access units follow: depth, then colour.
struct FrameHead {
  bool keyframe = false;
  std::uint64_t sequence = 0;
  Instant sent_at{};  ///< When the frame was encoded, on the server's clock.
  FrameCounters counters;
  StageDurations durations;  ///< Sent in microseconds, at most 71 minutes.
  std::uint32_t depth_bytes = 0;
  std::uint32_t color_bytes = 0;  ///< Zero if there is no colour.
};

/// After these reasons, the server has sent everything and does not start again by itself. After
/// any other reason the server may be started again.
inline constexpr std::string_view kRecordingIsOver = "the recording is over";
inline constexpr std::string_view kAllFramesAreSent = "all frames that --frames asked for are sent";

struct EndOfStream {
  std::string reason;  ///< One sentence.

  bool is_final() const { return reason == kRecordingIsOver || reason == kAllFramesAreSent; }
  friend bool operator==(const EndOfStream&, const EndOfStream&) = default;
};

/// The reason why the camera sends no frames at present. Empty once the camera works again.
struct CameraStatus {
  std::string text;  ///< One sentence.
  friend bool operator==(const CameraStatus&, const CameraStatus&) = default;
};

struct FrameAck {
  std::uint64_t sequence = 0;
  friend bool operator==(const FrameAck&, const FrameAck&) = default;
};

struct Ping {
  Instant client_time{};
  friend bool operator==(const Ping&, const Ping&) = default;
};

struct Pong {
  Instant client_time{};  ///< Copied from the Ping.
  Instant server_time{};
  friend bool operator==(const Pong&, const Pong&) = default;
};

}  // namespace copresence::wire
