#include "web_gateway/forwarding/room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "tests/common/wire/sample_messages.h"
#include "tests/web_gateway/forwarding/made_frames.h"

namespace copresence::forwarding {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

/// Writes a viewer's messages down in few words: "state 1 waiting", "welcome 0", "frame 12".
class WrittenOutlet final : public Outlet {
 public:
  void send(ViewerMessage message) override {
    if (const auto* text = std::get_if<std::string>(&message)) {
      last_text_ = json::parse(*text);
      const std::string type = last_text_["type"];
      lines_.push_back(type == "room" ? type : type + " " + last_text_["camera"].dump());
      if (type == "state") lines_.back() += " " + last_text_["state"].get<std::string>();
    } else if (const auto* frame = std::get_if<SharedFrame>(&message)) {
      lines_.push_back("frame " + std::to_string((*frame)->frame.sequence));
    } else {
      last_bytes_ = std::get<wire::Bytes>(message);
      const auto header =
          wire::decode_header(std::span<const std::uint8_t>(last_bytes_).subspan<1, wire::kHeaderBytes>());
      ASSERT_TRUE(header);
      ASSERT_EQ(last_bytes_.size(), 1 + wire::kHeaderBytes + header->body_bytes);
      lines_.push_back(name(header->type) + " " + std::to_string(last_bytes_[0]));
    }
  }
  std::vector<std::string> take() { return std::exchange(lines_, {}); }
  const json& last_text() const { return last_text_; }
  /// The body of the last message of bytes.
  std::span<const std::uint8_t> last_body() const {
    return std::span<const std::uint8_t>(last_bytes_).subspan(1 + wire::kHeaderBytes);
  }

 private:
  static std::string name(wire::MessageType type) {
    switch (type) {
      case wire::MessageType::kWelcome:
        return "welcome";
      case wire::MessageType::kPong:
        return "pong";
      case wire::MessageType::kCameraStatus:
        return "status";
      case wire::MessageType::kEndOfStream:
        return "end";
      default:
        return "?";
    }
  }
  std::vector<std::string> lines_;
  json last_text_;
  wire::Bytes last_bytes_;
};

wire::Bytes from_viewer(std::uint8_t camera, const wire::Bytes& message) {
  wire::Bytes bytes = {camera};
  bytes.insert(bytes.end(), message.begin(), message.end());
  return bytes;
}

class RoomTest : public testing::Test {
 protected:
  void connect(std::size_t camera, Duration offset = {}) {
    room_.take(camera, Connected{wire::sample_description(), {offset, {}}}, now_);
  }
  void camera_sends(std::size_t camera, bool keyframe = false) {
    now_ += kPeriod;
    room_.take(camera, FrameCame{made_frame(++sequence_, keyframe, 1000, now_), {}}, now_);
  }

  Instant now_ = kBegin;
  std::uint64_t sequence_ = 0;
  std::vector<std::size_t> requests_;
  WrittenOutlet outlet_;
  Room room_{{{"left", "127.0.0.1:7001"}, {"", "127.0.0.1:7002"}},
             [this](std::size_t camera) { requests_.push_back(camera); }};
};

TEST_F(RoomTest, AViewerWhoComesFirstLearnsWhatTheCamerasDo) {
  const auto viewer = room_.join(outlet_, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("room", "state 0 connecting", "state 1 connecting"));
  connect(1);
  EXPECT_THAT(outlet_.take(), ElementsAre("state 1 connected", "welcome 1", "clock 1"));
  camera_sends(1, true);
  EXPECT_THAT(outlet_.take(), ElementsAre("frame 1"));
  room_.take(1, StatusChanged{"unplugged"}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("status 1", "state 1 waiting"));
  EXPECT_EQ(outlet_.last_text()["text"], "unplugged");
  room_.take(1, StatusChanged{""}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("status 1", "state 1 connected"));
  room_.take(1, Disconnected{"the recording is over", true, false}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("end 1", "state 1 waiting"));
  room_.take(0, Disconnected{"another version", false, true}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("state 0 failed"));
}

TEST_F(RoomTest, AViewerWhoComesLaterGetsAPictureAtOnce) {
  connect(0);
  camera_sends(0, true);
  camera_sends(0);
  room_.take(0, StatusChanged{"unplugged"}, now_);
  const auto viewer = room_.join(outlet_, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("room", "state 0 waiting", "state 1 connecting", "welcome 0",
                                          "clock 0", "status 0", "frame 1", "frame 2"));
  EXPECT_THAT(requests_, IsEmpty());
}

TEST_F(RoomTest, TheWelcomeHasTheServersTimeAndDescription) {
  connect(0, 5s);
  now_ += 1s;
  const auto viewer = room_.join(outlet_, now_);
  const auto welcome = wire::decode_welcome(outlet_.last_body());
  ASSERT_TRUE(welcome);
  EXPECT_EQ(welcome->description, wire::sample_description());
  EXPECT_EQ(welcome->server_time, now_ + 5s);
  EXPECT_EQ(outlet_.last_text()["offset_us"], 5'000'000);
}

TEST_F(RoomTest, AChangedClockIsAnnouncedAndNoiseIsNot) {
  connect(0);
  const auto viewer = room_.join(outlet_, now_);
  outlet_.take();
  room_.take(0, FrameCame{made_frame(1, true), {400us, 50us}}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("frame 1"));
  room_.take(0, FrameCame{made_frame(2, false), {600us, 50us}}, now_);
  EXPECT_THAT(outlet_.take(), ElementsAre("clock 0", "frame 2"));
}

TEST_F(RoomTest, AKeyframeIsRequestedAtMostOnceASecondForAllViewersTogether) {
  connect(0);
  camera_sends(0);  // The frames since the keyframe are not there.
  WrittenOutlet other_outlet;
  const auto viewer = room_.join(outlet_, now_);
  const auto other = room_.join(other_outlet, now_);
  for (int i = 0; i < 20; ++i) camera_sends(0);
  EXPECT_THAT(requests_, ElementsAre(0u));
  for (int i = 0; i < 20; ++i) camera_sends(0);
  EXPECT_THAT(requests_, ElementsAre(0u, 0u));
  EXPECT_TRUE(viewer->take(from_viewer(1, wire::encode_keyframe_request()), now_));
  EXPECT_EQ(requests_.size(), 2u) << "camera 1 has no connection";
}

TEST_F(RoomTest, PingsAreAnsweredOnTheGatewaysClock) {
  const auto viewer = room_.join(outlet_, now_);
  outlet_.take();
  EXPECT_TRUE(viewer->take(from_viewer(1, encode(wire::Ping{Instant{} + 3s})), now_));
  EXPECT_THAT(outlet_.take(), ElementsAre("pong 1"));
  const auto pong = wire::decode_pong(outlet_.last_body());
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->client_time, Instant{} + 3s);
  EXPECT_EQ(pong->server_time, now_);
}

TEST_F(RoomTest, MessagesThatViolateTheProtocolAreErrors) {
  connect(0);
  const auto viewer = room_.join(outlet_, now_);
  camera_sends(0, true);
  EXPECT_TRUE(viewer->take(from_viewer(0, encode(wire::FrameAck{1})), now_));
  EXPECT_FALSE(viewer->take(from_viewer(0, encode(wire::FrameAck{1})), now_)) << "acknowledged twice";
  EXPECT_FALSE(viewer->take(from_viewer(2, encode(wire::Ping{now_})), now_)) << "no such camera";
  EXPECT_FALSE(viewer->take(from_viewer(0, encode(wire::Hello{})), now_)) << "not for a page";
  EXPECT_FALSE(viewer->take({}, now_));
  wire::Bytes longer = from_viewer(0, encode(wire::Ping{now_}));
  longer.push_back(0);
  EXPECT_FALSE(viewer->take(longer, now_));
  EXPECT_FALSE(viewer->take(wire::Bytes{0, 1, 2, 3}, now_));
}

TEST_F(RoomTest, AViewerWhoLeavesGetsNothingMore) {
  connect(0);
  auto viewer = room_.join(outlet_, now_);
  viewer.reset();
  outlet_.take();
  camera_sends(0, true);
  EXPECT_THAT(outlet_.take(), IsEmpty());
}

TEST_F(RoomTest, WaitsSinceTheOldestFrameInFlightOfAnyCamera) {
  connect(0);
  connect(1);
  const auto viewer = room_.join(outlet_, now_);
  EXPECT_FALSE(viewer->waits_since());
  camera_sends(1, true);
  const Instant first = now_;
  camera_sends(0, true);
  EXPECT_EQ(viewer->waits_since(), first);
}

}  // namespace
}  // namespace copresence::forwarding
