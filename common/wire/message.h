#pragma once

// What the two processes say to each other. docs/internals/wire_format.md draws every message byte by byte; a test
// holds that page against message_codec.h.
//
// Every message is a header of 8 bytes and a body; numbers are little-endian. The client speaks first
// (Hello), the server answers with a Reject or a Welcome and then sends frames; the client acknowledges each
// one. Hello and Reject keep their layout in every version, so that any two releases can tell each other
// apart.
//
// Thread: values.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"

namespace copresence::wire {

/// Both ends must have the same: there is no compatibility code. Raise it with every change of a released
/// format.
inline constexpr std::uint32_t kProtocolVersion = 6;
inline constexpr std::array<char, 8> kMagic = {'C', 'O', 'P', 'R', 'E', 'S', 'N', 'C'};

inline constexpr std::size_t kHeaderBytes = 8;
inline constexpr std::size_t kFrameHeadBytes = 96;  ///< of a frame's body, before its access units
inline constexpr std::size_t kMaxMessageBytes = 8 * 1024 * 1024;  ///< body of the largest message, a frame
inline constexpr std::size_t kMaxTextBytes = 512;                 ///< a sentence for a person, UTF-8
inline constexpr std::size_t kMaxNameBytes = 64;   ///< a camera's, a codec's, a parameter's name
inline constexpr std::size_t kMaxParameters = 64;  ///< of a depth codec

enum class MessageType : std::uint8_t {
  kHello = 1,            ///< client: the first message
  kKeyframeRequest = 2,  ///< client: what follows cannot be decoded without a keyframe
  kFrameAck = 3,         ///< client: this frame and all before it have arrived
  kPing = 4,             ///< client: what time is it?
  kReject = 17,          ///< server: instead of Welcome; nothing follows
  kWelcome = 18,         ///< server: what is going to be streamed
  kFrame = 19,           ///< server: one EncodedFrame
  kEndOfStream = 20,     ///< server: nothing follows
  kPong = 21,            ///< server: answer to Ping
  kCameraStatus = 22,    ///< server: how its camera is, when that changes
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
  kVersion = 1,  ///< final: trying again is of no use
  kFull = 2,     ///< as many clients as the server takes; one may leave
};

struct Reject {
  RejectReason reason = RejectReason::kVersion;
  std::string text;  ///< one sentence
  friend bool operator==(const Reject&, const Reject&) = default;
};

struct Welcome {
  std::uint64_t clock_id = 0;  ///< monotonic_clock_id(): equal where both ends read one clock; 0 unknown
  Instant server_time{};       ///< when this was written: the first answer to "what time is it?"
  StreamDescription description;
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

/// Where the frames of a stream went, counted from its start. For two frames a and b that a client received
/// one after the other, b.sequence - a.sequence - 1 = the growth of encoder_busy plus that of window_full.
struct FrameCounters {
  std::uint64_t captured = 0;  ///< frames the server had from its sensor
  std::uint64_t encoder_busy =
      0;  ///< never encoded: a newer one was there, or nearly, before the encoder was free
  std::uint64_t window_full = 0;  ///< not sent: this client had not acknowledged enough of the ones before

  // What became of the sensor's pictures.
  std::uint64_t depth_without_color = 0;  ///< frames whose colour is an older picture, or none
  std::uint64_t color_without_depth = 0;  ///< colour pictures that no frame carried
  std::uint64_t damaged = 0;              ///< pictures that did not decode, or that a recording lacks
  std::uint64_t late = 0;                 ///< pictures that the next one replaced before they were taken
  std::uint64_t dark = 0;                 ///< depth pictures that its projector was not to light, left out
  // `damaged` and `late` travel in 32 bits each and stay at the largest number that these hold.
  friend bool operator==(const FrameCounters&, const FrameCounters&) = default;
};

/// A frame without its access units, which follow it: first depth, then colour.
struct FrameHead {
  bool keyframe = false;
  std::uint64_t sequence = 0;
  Instant sent_at{};  ///< server's clock, when the encoder was done: the wire stage begins
  FrameCounters counters;
  StageDurations durations;  ///< travel as microseconds, at most 71 minutes
  std::uint32_t depth_bytes = 0;
  std::uint32_t color_bytes = 0;  ///< 0: no colour
};

/// After these two reasons a server does not come back by itself: it has sent what it was asked to send. After
/// any other reason a client may expect that somebody starts the server again.
inline constexpr std::string_view kRecordingIsOver = "the recording is over";
inline constexpr std::string_view kAllFramesAreSent = "all frames that --frames asked for are sent";

struct EndOfStream {
  std::string reason;  ///< one sentence

  bool is_final() const { return reason == kRecordingIsOver || reason == kAllFramesAreSent; }
  friend bool operator==(const EndOfStream&, const EndOfStream&) = default;
};

/// What keeps the server's camera from sending frames; it goes on by itself. Empty: nothing does any more.
struct CameraStatus {
  std::string text;  ///< one sentence
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
  Instant client_time{};  ///< the ping's
  Instant server_time{};
  friend bool operator==(const Pong&, const Pong&) = default;
};

}  // namespace copresence::wire
