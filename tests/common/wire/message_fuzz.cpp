// What a stranger may send: messages one after the other. The decoder must not crash, and what it accepts
// must be what the encoder would have written, byte for byte: the format has one spelling for every message.

#include <algorithm>
#include <cstdlib>
#include <span>

#include "common/wire/message_codec.h"

namespace copresence::wire {
namespace {

using Input = std::span<const std::uint8_t>;

template <class Message>
void expect_one_spelling(const Result<Message>& message, Input whole) {
  if (!message) return;
  const auto again = encode(*message);
  if (!std::equal(again.begin(), again.end(), whole.begin(), whole.end())) std::abort();
}

void decode_whole(MessageHeader header, Input whole) {
  const Input body = whole.subspan(kHeaderBytes);
  switch (header.type) {
    case MessageType::kHello:
      return expect_one_spelling(decode_hello(body), whole);
    case MessageType::kKeyframeRequest:
      return;
    case MessageType::kFrameAck:
      return expect_one_spelling(decode_frame_ack(body), whole);
    case MessageType::kPing:
      return expect_one_spelling(decode_ping(body), whole);
    case MessageType::kReject:
      return expect_one_spelling(decode_reject(body), whole);
    case MessageType::kWelcome:
      return expect_one_spelling(decode_welcome(body), whole);
    case MessageType::kFrame:
      return expect_one_spelling(decode_frame_head(body.first<kFrameHeadBytes>(), header.body_bytes),
                                 whole.first(kHeaderBytes + kFrameHeadBytes));
    case MessageType::kEndOfStream:
      return expect_one_spelling(decode_end_of_stream(body), whole);
    case MessageType::kCameraStatus:
      return expect_one_spelling(decode_camera_status(body), whole);
    case MessageType::kPong:
      return expect_one_spelling(decode_pong(body), whole);
  }
}

}  // namespace
}  // namespace copresence::wire

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace copresence::wire;
  Input rest(data, size);
  while (rest.size() >= kHeaderBytes) {
    const auto header = decode_header(rest.first<kHeaderBytes>());
    if (!header || rest.size() < kHeaderBytes + header->body_bytes) break;
    decode_whole(*header, rest.first(kHeaderBytes + header->body_bytes));
    rest = rest.subspan(kHeaderBytes + header->body_bytes);
  }
  return 0;
}
