#include "web_gateway/forwarding/viewer_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/web_gateway/forwarding/made_frames.h"

namespace copresence::forwarding {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// One viewer of one camera. The camera sends a frame every period.
class ViewerStreamTest : public testing::Test {
 protected:
  void camera_sends(bool keyframe, std::size_t bytes = 1000) {
    now_ += kPeriod;
    const SharedFrame frame = made_frame(++newest_, keyframe, bytes, now_);
    group_.add(frame);
    stream_.frame_came(frame, group_, now_, send_);
  }
  void camera_sends_frames(int frames) {
    for (int i = 0; i < frames; ++i) camera_sends(false);
  }
  void acknowledge_all() {
    while (!unacknowledged_.empty()) {
      const auto sequence = unacknowledged_.front();
      unacknowledged_.erase(unacknowledged_.begin());
      ASSERT_TRUE(stream_.acknowledge(sequence, group_, now_ + 1ms, send_));
    }
  }
  void viewer_joins() { stream_.catch_up(group_, now_, send_); }
  bool needs_keyframe() const { return stream_.needs_keyframe(group_, now_); }
  std::vector<std::uint64_t> take_sent() { return std::exchange(sent_, {}); }

  Instant now_ = kBegin;
  std::uint64_t newest_ = 0;
  FrameGroup group_;
  ViewerStream stream_{kPeriod};
  std::vector<std::uint64_t> sent_, unacknowledged_;
  ViewerStream::Send send_ = [this](const SharedFrame& frame) {
    sent_.push_back(frame->frame.sequence);
    unacknowledged_.push_back(frame->frame.sequence);
  };
};

TEST_F(ViewerStreamTest, AViewerGetsEveryFrameInOrder) {
  camera_sends(true);
  acknowledge_all();
  for (int i = 0; i < 100; ++i) {
    camera_sends(false);
    acknowledge_all();
  }
  ASSERT_EQ(sent_.size(), 101u);
  for (std::size_t i = 0; i < sent_.size(); ++i) EXPECT_EQ(sent_[i], i + 1);
  EXPECT_FALSE(needs_keyframe());
}

TEST_F(ViewerStreamTest, AViewerWhoJoinsGetsTheKeptFramesAndThenTheNewOnes) {
  stream_ = ViewerStream(kPeriod);
  for (int i = 0; i < 4; ++i) group_.add(made_frame(++newest_, i == 0, 1000, now_));
  viewer_joins();
  EXPECT_THAT(take_sent(), ElementsAre(1, 2, 3, 4));
  camera_sends(false);
  EXPECT_THAT(take_sent(), ElementsAre(5));
  EXPECT_FALSE(needs_keyframe());
}

TEST_F(ViewerStreamTest, AViewerWhoJoinsGetsManyKeptFramesAtThePaceOfItsAcknowledgements) {
  for (int i = 0; i < 60; ++i) group_.add(made_frame(++newest_, i == 0, 1000, now_));
  viewer_joins();
  EXPECT_EQ(sent_.size(), wire::ClientWindow::kFramesOnUnknownPath);
  acknowledge_all();
  EXPECT_EQ(sent_.size(), 60u);
  camera_sends(false);
  EXPECT_EQ(sent_.back(), 61u);
}

TEST_F(ViewerStreamTest, AViewerWhoCatchesUpContinuesWithANewerKeyframe) {
  for (int i = 0; i < 60; ++i) group_.add(made_frame(++newest_, i == 0, 1000, now_));
  viewer_joins();
  take_sent();
  camera_sends(true);
  EXPECT_THAT(take_sent(), IsEmpty()) << "the window is full";
  acknowledge_all();
  EXPECT_THAT(take_sent(), ElementsAre(61));
}

TEST_F(ViewerStreamTest, AViewerFarBehindNeedsAKeyframe) {
  for (int i = 0; i < 60; ++i) group_.add(made_frame(++newest_, i == 0, 1000, now_));
  viewer_joins();
  EXPECT_FALSE(needs_keyframe());
  now_ += 1s;
  EXPECT_TRUE(needs_keyframe());
}

TEST_F(ViewerStreamTest, WithoutKeptFramesAViewerNeedsAKeyframe) {
  group_.add(made_frame(++newest_, false));
  viewer_joins();
  EXPECT_THAT(take_sent(), IsEmpty());
  EXPECT_TRUE(needs_keyframe());
  camera_sends(true);
  EXPECT_THAT(take_sent(), ElementsAre(2));
}

TEST_F(ViewerStreamTest, AViewerWhoStopsGetsNothingUntilItHasAcknowledgedAndThenAKeyframe) {
  camera_sends(true);
  acknowledge_all();
  camera_sends_frames(600);
  const std::size_t in_flight = take_sent().size();
  EXPECT_LT(in_flight, 64u);
  EXPECT_FALSE(needs_keyframe()) << "a keyframe would not be sent now";
  camera_sends(true);
  EXPECT_THAT(take_sent(), IsEmpty());
  group_.clear();
  acknowledge_all();
  EXPECT_TRUE(needs_keyframe());
  camera_sends(false);
  EXPECT_THAT(take_sent(), IsEmpty()) << "it cannot be decoded";
  camera_sends(true);
  camera_sends(false);
  EXPECT_THAT(take_sent(), ElementsAre(newest_ - 1, newest_));
}

TEST_F(ViewerStreamTest, AViewerWhoFellBehindContinuesWithKeptFramesThatAreNewer) {
  camera_sends(true);
  acknowledge_all();
  camera_sends_frames(100);
  camera_sends(true);
  camera_sends(false);
  take_sent();
  acknowledge_all();
  EXPECT_THAT(take_sent(), ElementsAre(newest_ - 1, newest_));
}

TEST_F(ViewerStreamTest, AViewerWhoFellBehindNeverGoesBackInTime) {
  camera_sends(true);
  acknowledge_all();
  camera_sends_frames(100);
  take_sent();
  acknowledge_all();
  EXPECT_THAT(take_sent(), IsEmpty()) << "the kept keyframe is older than what the viewer has";
  EXPECT_TRUE(needs_keyframe());
}

TEST_F(ViewerStreamTest, AnAcknowledgementOfAFrameThatIsNotInFlightIsAnError) {
  camera_sends(true);
  EXPECT_FALSE(stream_.acknowledge(2, group_, now_, send_));
  EXPECT_TRUE(stream_.acknowledge(1, group_, now_, send_));
  EXPECT_FALSE(stream_.acknowledge(1, group_, now_, send_));
}

TEST_F(ViewerStreamTest, FramesOfANewConnectionWaitForTheAcknowledgementsOfTheOld) {
  camera_sends(true);
  camera_sends(false);
  stream_.restart(kPeriod);
  group_.clear();
  newest_ = 0;
  take_sent();
  camera_sends(true);
  EXPECT_THAT(take_sent(), IsEmpty()) << "frame 1 of the old connection is still in flight";
  unacknowledged_ = {1, 2};
  acknowledge_all();
  EXPECT_THAT(take_sent(), ElementsAre(1));
}

}  // namespace
}  // namespace copresence::forwarding
