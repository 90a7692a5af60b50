#include "render_client/stream/reconnecting_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

namespace copresence::stream {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Gives a number of frames, then fails.
class ScriptedSource final : public FrameSource {
 public:
  ScriptedSource(int frames, Error end, int& keyframe_requests)
      : frames_(frames), end_(std::move(end)), keyframe_requests_(keyframe_requests) {
    description_.camera = "left";
  }
  const StreamDescription& description() const override { return description_; }
  Result<wire::ReceivedFrame> next(std::stop_token, std::optional<Instant>) override {
    if (frames_-- > 0) return wire::ReceivedFrame{};
    return fail(end_);
  }
  void request_keyframe() override { ++keyframe_requests_; }
  wire::ClockOffset clock() const override { return {}; }
  void on_status(std::function<void(const std::string&)>) override {}

 private:
  StreamDescription description_;
  int frames_;
  Error end_;
  int& keyframe_requests_;
};

class ReconnectingSourceTest : public ::testing::Test {
 protected:
  ReconnectingSource source() {
    return {"host:1",
            0,
            states_,
            log_,
            [this](const std::stop_token&) -> Result<std::unique_ptr<FrameSource>> {
              ++tries_;
              if (ends_.empty()) return fail(ErrorCode::kRefused, "host:1: another release");
              const Error end = ends_.front();
              ends_.pop_front();
              return std::make_unique<ScriptedSource>(1, end, keyframe_requests_);
            },
            [this](const StreamDescription& description) -> Result<std::string> {
              begun_.push_back(description.camera);
              if (!can_decode_) return fail(ErrorCode::kUnsupported, "unknown codec");
              return "a remark";
            }};
  }

  int tries_ = 0, keyframe_requests_ = 0;
  bool can_decode_ = true;
  std::deque<Error> ends_;  // how each connection ends after its one frame
  std::vector<std::string> begun_, lines_;
  CameraStates states_{{{"host:1", ""}}};
  wire::LimitedLog log_{
      [this](wire::LimitedLog::Severity, const std::string& line) { lines_.push_back(line); }};
};

TEST_F(ReconnectingSourceTest, ConnectsAgainUntilItIsRefused) {
  ends_ = {{ErrorCode::kNotFound, "host:1: connection lost"}, {ErrorCode::kEndOfStream, "goodbye"}};
  ReconnectingSource frames = source();
  EXPECT_TRUE(frames.next({}));
  frames.decoded();
  EXPECT_TRUE(frames.next({})) << "of the second connection";
  const auto refused = frames.next({});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_EQ(tries_, 3);
  EXPECT_THAT(begun_, ElementsAre("left", "left"));
  EXPECT_TRUE(states_.all_refused());
  log_.finish();
  EXPECT_THAT(lines_.front(), HasSubstr("connected to camera \"left\""));
  EXPECT_THAT(lines_, ::testing::Contains(HasSubstr("host:1: a remark")));
  EXPECT_THAT(lines_, ::testing::Contains(HasSubstr("host:1: goodbye")));
}

TEST_F(ReconnectingSourceTest, RequestsAKeyframeForAFrameThatCannotBeDecoded) {
  ends_ = {{ErrorCode::kNotFound, "host:1: connection lost"}};
  ReconnectingSource frames = source();
  ASSERT_TRUE(frames.next({}));
  frames.undecodable("damaged");
  EXPECT_EQ(keyframe_requests_, 1);
}

TEST_F(ReconnectingSourceTest, LeavesOutACameraWhoseStreamThisProgramCannotDecode) {
  ends_ = {{ErrorCode::kNotFound, ""}};
  can_decode_ = false;
  ReconnectingSource frames = source();
  EXPECT_FALSE(frames.next({}));
  EXPECT_EQ(tries_, 2);
}

TEST_F(ReconnectingSourceTest, StopsWhenAskedTo) {
  ReconnectingSource frames = source();
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = frames.next(stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(tries_, 0);
}

}  // namespace
}  // namespace copresence::stream
