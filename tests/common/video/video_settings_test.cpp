#include "common/video/video_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::video {
namespace {

TEST(VideoSettings, TakesTheDefaultsAndBothEndsOfEveryRange) {
  EXPECT_TRUE(check({}));
  EXPECT_TRUE(check({.depth_qp = 0, .depth_kbps = kMinKbps, .color_kbps = kMaxKbps}));
  EXPECT_TRUE(check({.depth_qp = kMaxDepthQp, .depth_kbps = kMaxKbps, .color_kbps = kMinKbps}));
}

TEST(VideoSettings, RefusesTheRestWithTheNumberAndItsRange) {
  for (const VideoSettings& settings :
       {VideoSettings{.depth_qp = -1}, VideoSettings{.depth_qp = 99}, VideoSettings{.depth_kbps = 0},
        VideoSettings{.depth_kbps = 1'000'000}, VideoSettings{.color_kbps = 7}}) {
    const auto checked = check(settings);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(checked.error().what, testing::ContainsRegex("of -?[0-9]+.*give [0-9]+.*to [0-9]+"));
  }
}

}  // namespace
}  // namespace copresence::video
