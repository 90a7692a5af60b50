#include "common/wire/message_codec.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>

#include "common/frame/bounds.h"
#include "common/wire/clock_offset.h"
#include "tests/common/wire/raw_peer.h"
#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

using testing::HasSubstr;

std::span<const std::uint8_t, kHeaderBytes> header_of(const Bytes& message) {
  return std::span(message).first<kHeaderBytes>();
}

Result<void> decoded(MessageType type, std::span<const std::uint8_t> body) {
  const auto outcome = [](const auto& result) -> Result<void> {
    if (!result) return fail(result.error());
    return {};
  };
  switch (type) {
    case MessageType::kHello:
      return outcome(decode_hello(body));
    case MessageType::kReject:
      return outcome(decode_reject(body));
    case MessageType::kWelcome:
      return outcome(decode_welcome(body));
    case MessageType::kEndOfStream:
      return outcome(decode_end_of_stream(body));
    case MessageType::kCameraStatus:
      return outcome(decode_camera_status(body));
    case MessageType::kFrameAck:
      return outcome(decode_frame_ack(body));
    case MessageType::kPing:
      return outcome(decode_ping(body));
    case MessageType::kPong:
      return outcome(decode_pong(body));
    case MessageType::kFrame:
      return outcome(
          decode_frame_head(body.first<kFrameHeadBytes>(), static_cast<std::uint32_t>(body.size())));
    case MessageType::kKeyframeRequest:
      return {};
  }
  return {};
}

StreamDescription with(const std::function<void(StreamDescription&)>& change) {
  StreamDescription stream = sample_description();
  change(stream);
  return stream;
}

TEST(MessageCodec, GivesBackWhatWasSaid) {
  EXPECT_EQ(*decode_hello(body_of(encode(Hello{7}))), Hello{7});
  const Reject reject{RejectReason::kFull, "full"};
  EXPECT_EQ(*decode_reject(body_of(encode(reject))), reject);
  const Reject of_a_later_release{RejectReason{200}, "something new"};
  EXPECT_EQ(*decode_reject(body_of(encode(of_a_later_release))), of_a_later_release);
  EXPECT_EQ(*decode_welcome(body_of(encode(sample_welcome()))), sample_welcome());
  EXPECT_EQ(*decode_end_of_stream(body_of(encode(EndOfStream{"Ende: Küche"}))), EndOfStream{"Ende: Küche"});
  EXPECT_EQ(*decode_camera_status(body_of(encode(CameraStatus{"unplugged"}))), CameraStatus{"unplugged"});
  EXPECT_EQ(*decode_camera_status(body_of(encode(CameraStatus{}))), CameraStatus{});
  EXPECT_EQ(decode_frame_ack(body_of(encode(FrameAck{9})))->sequence, 9u);
  EXPECT_EQ(*decode_ping(body_of(encode(Ping{at_ns(77)}))), Ping{at_ns(77)});
  EXPECT_EQ(*decode_pong(body_of(encode(Pong{at_ns(77), at_ns(78)}))), (Pong{at_ns(77), at_ns(78)}));
}

TEST(MessageCodec, GivesBackAFramesHead) {
  const FrameHead head = sample_frame_head();
  const FrameHeadMessage message = encode(head);
  const auto header = decode_header(std::span(message).first<kHeaderBytes>());
  ASSERT_TRUE(header);
  EXPECT_EQ(header->body_bytes, kFrameHeadBytes + head.depth_bytes + head.color_bytes);
  const auto back = decode_frame_head(std::span(message).last<kFrameHeadBytes>(), header->body_bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->keyframe, head.keyframe);
  EXPECT_EQ(back->sequence, head.sequence);
  EXPECT_EQ(back->sent_at, head.sent_at);
  EXPECT_EQ(back->counters, head.counters);
  EXPECT_EQ(back->durations.fill, head.durations.fill);
  EXPECT_EQ(back->durations.video_encode, head.durations.video_encode);
  EXPECT_EQ(back->depth_bytes, head.depth_bytes);
  EXPECT_EQ(back->color_bytes, head.color_bytes);
}

TEST(MessageCodec, SaturatesDurationsInsteadOfWrapping) {
  FrameHead head = sample_frame_head();
  head.durations.fill = std::chrono::hours(3);
  head.durations.capture = -std::chrono::seconds(1);
  const FrameHeadMessage message = encode(head);
  const auto back = decode_frame_head(std::span(message).last<kFrameHeadBytes>(), 188);
  EXPECT_EQ(back->durations.fill, std::chrono::microseconds(0xffffffff));
  EXPECT_EQ(back->durations.capture, Duration::zero());
}

TEST(MessageCodec, RefusesEveryTruncation) {
  for (const auto& [name, message] : sample_messages()) {
    const auto header = decode_header(header_of(message));
    ASSERT_TRUE(header) << name;
    if (header->type == MessageType::kFrame || header->type == MessageType::kKeyframeRequest) continue;
    for (std::size_t size = 0; size + kHeaderBytes < message.size(); ++size) {
      EXPECT_FALSE(decoded(header->type, body_of(message).first(size))) << name << " cut to " << size;
    }
    Bytes longer = message;
    longer.push_back(0);
    EXPECT_FALSE(decoded(header->type, body_of(longer))) << name << " with a byte too many";
  }
}

TEST(MessageCodec, SurvivesEveryFlippedBit) {
  for (const auto& [name, message] : sample_messages()) {
    for (std::size_t bit = 0; bit < 8 * message.size(); ++bit) {
      Bytes damaged = message;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
      const auto header = decode_header(header_of(damaged));
      if (!header || header->body_bytes + kHeaderBytes != damaged.size()) continue;
      const auto outcome = decoded(header->type, body_of(damaged));
      EXPECT_TRUE(outcome || outcome.error().code == ErrorCode::kCorrupt) << name << " bit " << bit;
    }
  }
}

TEST(MessageCodec, KnowsASizeBeforeAnythingIsAllocated) {
  const auto refuses = [](std::uint32_t bytes, std::uint32_t type) {
    Bytes header;
    for (const std::uint32_t number : {bytes, type}) {
      for (int i = 0; i < 4; ++i) header.push_back(static_cast<std::uint8_t>(number >> 8 * i));
    }
    return !decode_header(header_of(header));
  };
  EXPECT_TRUE(refuses(kMaxMessageBytes + 1, 19));
  EXPECT_FALSE(refuses(kMaxMessageBytes, 19));
  EXPECT_TRUE(refuses(kFrameHeadBytes, 19));
  EXPECT_TRUE(refuses(11, 1));
  EXPECT_TRUE(refuses(0xffffffff, 18));
  EXPECT_TRUE(refuses(8, 0));
  EXPECT_TRUE(refuses(8, 256 + 4));
}

TEST(MessageCodec, RefusesAFrameThatContradictsItself) {
  const auto refuses = [](std::size_t at, std::uint8_t value) {
    FrameHeadMessage message = encode(sample_frame_head());
    message[kHeaderBytes + at] = value;
    return !decode_frame_head(std::span(message).last<kFrameHeadBytes>(), 188);
  };
  EXPECT_TRUE(refuses(15, 0xff));  // sent 290 years from now
  EXPECT_TRUE(refuses(56, 2));     // a flag nobody knows
  EXPECT_TRUE(refuses(61, 1));     // more depth than the frame has bytes
  EXPECT_FALSE(refuses(60, 1));    // all but one byte is colour
  EXPECT_TRUE(refuses(60, 0));     // no depth
}

/// Writes each of some extreme numbers at every place of every message. What is accepted must lie within the bounds.
TEST(MessageCodec, BelievesNoExtremeNumbers) {
  const auto bytes_of = [](std::uint64_t number) {
    std::array<std::uint8_t, 8> bytes;
    for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(number >> 8 * i);
    return bytes;
  };
  const auto of_double = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  const double infinite = std::numeric_limits<double>::infinity();
  const auto is_sound = [](Instant instant) {
    return instant >= Instant{} && instant < Instant(std::chrono::nanoseconds(kNumberBound));
  };
  for (const std::uint64_t extreme :
       {std::uint64_t{0}, kNumberBound - 1, kNumberBound, std::uint64_t{1} << 62, std::uint64_t{1} << 63,
        ~std::uint64_t{0}, of_double(infinite), of_double(-infinite), of_double(std::nan("")),
        of_double(1e300), of_double(-1e300), of_double(1e-300), of_double(5e-324), of_double(-0.0)}) {
    const auto bytes = bytes_of(extreme);
    for (const auto& [name, message] : sample_messages()) {
      for (std::size_t at = 0; at + kHeaderBytes + 8 <= message.size(); ++at) {
        Bytes changed = message;
        std::copy(bytes.begin(), bytes.end(),
                  changed.begin() + static_cast<std::ptrdiff_t>(kHeaderBytes + at));
        const auto body = body_of(changed);
        const std::string where = fmt::format("{} at {}: {:x}", name, at, extreme);
        switch (type_of(changed)) {
          case MessageType::kWelcome: {
            const auto welcome = decode_welcome(body);
            if (!welcome) break;
            EXPECT_TRUE(is_sound(welcome->server_time)) << where;
            EXPECT_TRUE(check(welcome->description)) << where;
            ClockEstimate clock;
            clock.add(at_ns(1), welcome->server_time, at_ns(2));
            EXPECT_LE(std::chrono::abs(clock.at(at_ns(3)).to_local(Instant{}) - Instant{}),
                      std::chrono::hours(24 * 366 * 74));
            break;
          }
          case MessageType::kFrame: {
            const auto head = decode_frame_head(std::span(changed).last<kFrameHeadBytes>(), 196);
            if (!head) break;
            EXPECT_TRUE(is_sound(head->sent_at)) << where;
            for (const std::uint64_t counter :
                 {head->sequence, head->counters.captured, head->counters.encoder_busy,
                  head->counters.window_full, head->counters.depth_without_color,
                  head->counters.color_without_depth, head->counters.damaged, head->counters.dark}) {
              EXPECT_LT(counter, kNumberBound) << where;
            }
            break;
          }
          case MessageType::kPing: {
            const auto ping = decode_ping(body);
            EXPECT_TRUE(!ping || is_sound(ping->client_time)) << where;
            break;
          }
          case MessageType::kPong: {
            const auto pong = decode_pong(body);
            EXPECT_TRUE(!pong || (is_sound(pong->client_time) && is_sound(pong->server_time))) << where;
            break;
          }
          default:
            static_cast<void>(decoded(type_of(changed), body));
        }
      }
    }
  }
}

TEST(MessageCodec, BelievesNoImpossibleStream) {
  const auto error = [](const std::function<void(StreamDescription&)>& change) {
    const auto checked = check(with(change));
    return checked ? std::string("none") : checked.error().what;
  };
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error([](StreamDescription&) {}), "none");
  EXPECT_THAT(error([](auto& s) { s.camera = ""; }), HasSubstr("name"));
  EXPECT_THAT(error([](auto& s) { s.camera = std::string(65, 'x'); }), HasSubstr("name"));
  EXPECT_THAT(error([](auto& s) { s.camera = "left\x1b[2J"; }), HasSubstr("name"));
  EXPECT_THAT(error([](auto& s) { s.model.width = 641; }), HasSubstr("even"));
  EXPECT_THAT(error([&](auto& s) { s.model.distortion[5] = infinite; }), HasSubstr("finite"));
  EXPECT_THAT(error([](auto& s) { s.unit = DepthUnit(10); }), HasSubstr("unit"));
  EXPECT_THAT(error([](auto& s) { s.range = {5, 0.4}; }), HasSubstr("range"));
  EXPECT_THAT(error([&](auto& s) { s.range.near_m = std::nan(""); }), HasSubstr("range"));
  EXPECT_THAT(error([&](auto& s) { s.range = {1e-9, 1e-8}; }), HasSubstr("range"));
  EXPECT_THAT(error([&](auto& s) { s.range = {1, 1 + 1e-9}; }), HasSubstr("range"));
  for (const double focal : {1e-300, 1e-3, 1e9, 1e300}) {
    EXPECT_THAT(error([focal](auto& s) { s.model.fx = focal; }), HasSubstr("focal length")) << focal;
  }
  EXPECT_THAT(error([](auto& s) { s.model.cy = -1e300; }), HasSubstr("principal point"));
  EXPECT_THAT(error([](auto& s) { s.frames_per_second = 1e-300; }), HasSubstr("rate"));
  EXPECT_THAT(error([](auto& s) { s.world_from_camera.rotation *= 2; }), HasSubstr("pose"));
  EXPECT_THAT(error([](auto& s) { s.world_from_camera.translation.x() = 1e9; }), HasSubstr("pose"));
  EXPECT_THAT(error([](auto& s) { s.noise.disparity_constant_m = 0; }), HasSubstr("depth noise"));
  EXPECT_THAT(error([](auto& s) { s.noise.disparity_constant_m = 1e300; }), HasSubstr("depth noise"));
  EXPECT_THAT(error([](auto& s) { s.noise.sigma_steps = std::nan(""); }), HasSubstr("depth noise"));
  EXPECT_THAT(error([](auto& s) { s.codec.format = PixelFormat(9); }), HasSubstr("pixel format"));
  EXPECT_THAT(error([](auto& s) { s.codec.name.clear(); }), HasSubstr("codec"));
  EXPECT_THAT(error([&](auto& s) { s.codec.parameters[0].second = infinite; }), HasSubstr("finite"));
  EXPECT_THAT(error([](auto& s) { s.codec.parameters.resize(65, {"p", 1}); }), HasSubstr("at most 64"));
}

TEST(MessageCodec, PutsNoControlCharactersOnAnybodysTerminal) {
  const auto said =
      decode_end_of_stream(body_of(encode(EndOfStream{"a\n\x1b[2J\xff" + std::string(600, 'x')})));
  ASSERT_TRUE(said);
  EXPECT_THAT(said->reason, testing::StartsWith("a??[2J?xxx"));
  EXPECT_EQ(said->reason.size(), kMaxTextBytes);
  const Bytes hostile = {3, 0, 'a', 7, 'b'};
  EXPECT_FALSE(decode_end_of_stream(hostile));
}

}  // namespace
}  // namespace copresence::wire
