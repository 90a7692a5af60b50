#include "tools/record/recording_info.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/real_recordings.h"
#include "tests/support/recording_scene.h"

namespace copresence::record {
namespace {

using testing::HasSubstr;

const recording::ProgressReport kNobodyWatches = [](double) {};

class RecordingInfoTest : public testing::Test {
 protected:
  RecordingInfo look(const test::RecordingScene& scene) const {
    test::write_recording(folder_.file("a.oni"), scene);
    const auto info = read_info(folder_.file("a.oni"), kNobodyWatches);
    EXPECT_TRUE(info) << info.error().what;
    return info.value_or(RecordingInfo{});
  }

  const test::TemporaryFolder folder_;
};

TEST_F(RecordingInfoTest, CountsFramesHolesAndLevels) {
  const RecordingInfo info = look({.frames = 12});
  EXPECT_TRUE(info.finished);
  ASSERT_EQ(info.streams.size(), 2u);
  EXPECT_EQ(info.streams[0].frames, 12u);
  EXPECT_EQ(info.streams[0].frames_missing, 0u);
  EXPECT_NEAR(info.streams[0].fps, 30, 0.01);
  EXPECT_NEAR(info.seconds, 0.4, 1e-3);
  ASSERT_TRUE(info.depth);
  EXPECT_NEAR(info.depth->holes_percent, 100.0 / 9, 0.1);
  std::set<int> levels;
  for (int frame = 0; frame < 12; ++frame) {
    const DepthImage depth = test::RecordingScene().depth_of(frame);
    for (const std::uint16_t value : depth.pixels()) levels.insert(value);
  }
  EXPECT_EQ(info.depth->levels, levels.size() - 1);  // 0 is none
  EXPECT_NEAR(info.depth->nearest_m, 0.601, 0.002);
  ASSERT_TRUE(info.color_after_depth_ms);
  EXPECT_NEAR(*info.color_after_depth_ms, 7.0, 1e-6);
  EXPECT_EQ(info.camera->name, "one");
}

TEST_F(RecordingInfoTest, FindsThePausesOfAStream) {
  const RecordingInfo info = look({.without_color = {3, 4, 8}});
  EXPECT_TRUE(info.streams[0].pauses.empty());
  const auto& pauses = info.streams[1].pauses;
  ASSERT_EQ(pauses.size(), 2u);
  EXPECT_EQ(pauses[0].after_frame, 3u);
  EXPECT_NEAR(pauses[0].ms, 100, 0.1);
  EXPECT_NEAR(pauses[1].ms, 66.7, 0.1);
}

TEST_F(RecordingInfoTest, SaysSoWhereARecordersEndIsMissing) {
  recording::OniContent content;
  content.camera.model = {64, 48, 58, 58, 31.5, 23.5, {}};
  content.color.reset();
  auto writer = recording::OniWriter::create(folder_.file("a.oni"), content);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write_depth(std::chrono::microseconds(0), DepthImage(64, 48, 900)));
  ASSERT_TRUE(writer->checkpoint());
  const auto info = read_info(folder_.file("a.oni"), kNobodyWatches);
  ASSERT_TRUE(info) << info.error().what;
  EXPECT_FALSE(info->finished);
  EXPECT_THAT(to_table(*info), HasSubstr("record repair"));
}

TEST_F(RecordingInfoTest, SaysWhenARecordingBeganByTheClock) {
  recording::OniContent content;
  content.camera.model = {64, 48, 58, 58, 31.5, 23.5, {}};
  content.color.reset();
  content.unix_zero_us = 1'650'000'000'000'000;
  auto writer = recording::OniWriter::create(folder_.file("a.oni"), content);
  ASSERT_TRUE(writer);
  for (const int ms : {250, 283, 316}) {
    ASSERT_TRUE(writer->write_depth(std::chrono::milliseconds(ms), DepthImage(64, 48, 900)));
  }
  ASSERT_TRUE(writer->finish());
  const auto info = read_info(folder_.file("a.oni"), kNobodyWatches);
  ASSERT_TRUE(info) << info.error().what;
  EXPECT_THAT(to_table(*info), HasSubstr("began 2022-04-15 05:20:00.250 UTC"));
  const auto json = nlohmann::json::parse(to_json(*info));
  EXPECT_NEAR(json["started_unix_s"].get<double>(), 1650000000.25, 1e-6);
  EXPECT_FALSE(nlohmann::json::parse(to_json(look({}))).contains("started_unix_s"));
}

TEST_F(RecordingInfoTest, SaysSoWhereTimesStandStill) {
  const RecordingInfo info = look({.frames = 60, .period_us = 0});
  EXPECT_EQ(info.streams[0].without_time, 59u);
  EXPECT_NEAR(info.seconds, 2, 0.01) << "as long as it plays";
  EXPECT_THAT(to_table(info), HasSubstr("stand still"));
}

TEST_F(RecordingInfoTest, SaysTheSameToProgramsAndToPeople) {
  const RecordingInfo info = look({});
  const auto json = nlohmann::json::parse(to_json(info));
  EXPECT_EQ(json["streams"][0]["kind"], "depth");
  EXPECT_EQ(json["streams"][0]["frames"], 12);
  EXPECT_EQ(json["streams"][0]["levels"], info.depth->levels);
  EXPECT_EQ(json["streams"][1]["kind"], "color");
  EXPECT_EQ(json["finished"], true);
  EXPECT_EQ(json["camera"]["name"], "one");
  const std::string table = to_table(info);
  EXPECT_THAT(table, HasSubstr("64x48"));
  EXPECT_THAT(table, HasSubstr("11.1 % holes"));
}

TEST_F(RecordingInfoTest, KnowsTheLevelsOfARealKinect) {
  const auto path = test::real_recording("arm_small.oni");
  if (!path) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
  const auto info = read_info(*path, kNobodyWatches);
  ASSERT_TRUE(info) << info.error().what;
  ASSERT_TRUE(info->depth);
  EXPECT_GT(info->depth->levels, 100u);
  EXPECT_LT(info->depth->levels, 1000u);
}

}  // namespace
}  // namespace copresence::record
