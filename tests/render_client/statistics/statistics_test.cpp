#include "render_client/statistics/statistics.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"

namespace copresence::statistics {
namespace {

using std::chrono::milliseconds;

Instant at(int ms) {
  return Instant(milliseconds(ms));
}

wire::FrameCounters totals(std::uint64_t captured, std::uint64_t encoder_busy = 0,
                           std::uint64_t window_full = 0) {
  return {.captured = captured, .encoder_busy = encoder_busy, .window_full = window_full};
}

TEST(CameraStatistics, CountsFromTheFirstFrameOn) {
  CameraStatistics camera;
  camera.connected();
  camera.received(totals(500, 20, 3), 1000, at(0));
  camera.decoded();
  const auto s = camera.snapshot();
  EXPECT_EQ(s.totals.captured, 1u);
  EXPECT_EQ(s.dropped, 0u);
  EXPECT_EQ(s.mbps, 0.0);
}

TEST(CameraStatistics, ComparesTwoSnapshots) {
  CameraStatistics camera;
  for (int i = 0; i < 10; ++i) {
    camera.received(totals(100 + i), 1000, at(100 * i));
    camera.displayed(i, milliseconds(200));
    camera.stage(Stage::kWire, milliseconds(20));
  }
  const auto before = camera.snapshot();
  for (int i = 10; i < 40; ++i) {
    camera.received(totals(100 + i), 25'000, at(100 * i));
    camera.displayed(i, milliseconds(50));
    camera.stage(Stage::kWire, milliseconds(5));
  }
  const CameraInterval between = interval(before, camera.snapshot(), milliseconds(2000));
  EXPECT_DOUBLE_EQ(between.frames_per_second, 15);
  EXPECT_DOUBLE_EQ(between.mbps, 30 * 25'000 * 8e-6 / 2);
  EXPECT_NEAR(between.latency_ms, 50, 1);
  EXPECT_NEAR(between.stages_ms[static_cast<std::size_t>(Stage::kWire)], 5, 0.1);
  EXPECT_EQ(between.stages_ms[static_cast<std::size_t>(Stage::kFill)], 0);
}

TEST(CameraStatistics, TellsWhyFramesAreMissing) {
  CameraStatistics camera;
  camera.received(totals(100, 7, 40), 1000, at(0));
  camera.received(totals(104, 9, 41), 1000,
                  at(100));  // three are missing, two of them because the encoder was busy
  camera.received(totals(105, 9, 41), 1000, at(200));
  camera.not_decoded();
  const auto s = camera.snapshot();
  EXPECT_EQ(s.totals.captured, 6u);
  EXPECT_EQ(s.received, 3u);
  EXPECT_EQ(s.drops.at("encoder_busy"), 2u);
  EXPECT_EQ(s.drops.at("window_full"), 1u);
  EXPECT_EQ(s.drops.at("decode_error"), 1u);
  EXPECT_EQ(s.drops.at("unaccounted"), 0u);
  EXPECT_EQ(s.dropped, 4u);
}

TEST(CameraStatistics, SaysSoWhereAFrameIsMissingThatNobodyKnowsOf) {
  CameraStatistics camera;
  camera.received(totals(100), 1000, at(0));
  camera.received(totals(103, 1), 1000, at(100));
  EXPECT_EQ(camera.snapshot().drops.at("unaccounted"), 1u);
}

TEST(CameraStatistics, CountsPicturesWithoutAPartnerFromTheFirstFrameOn) {
  CameraStatistics camera;
  camera.connected();
  camera.received({.captured = 7,
                   .depth_without_color = 10,
                   .color_without_depth = 20,
                   .damaged = 30,
                   .late = 5,
                   .dark = 40},
                  10, at(0));
  camera.received({.captured = 8,
                   .depth_without_color = 11,
                   .color_without_depth = 20,
                   .damaged = 33,
                   .late = 7,
                   .dark = 55},
                  10, at(33));
  camera.connected();  // to a restarted server
  camera.received({.captured = 1}, 10, at(500));
  camera.received({.captured = 2, .depth_without_color = 2, .color_without_depth = 1, .dark = 4}, 10,
                  at(533));
  const wire::FrameCounters counted = camera.snapshot().totals;
  EXPECT_EQ(counted.depth_without_color, 3u);
  EXPECT_EQ(counted.color_without_depth, 1u);
  EXPECT_EQ(counted.damaged, 3u);
  EXPECT_EQ(counted.late, 2u);
  EXPECT_EQ(counted.dark, 19u);
}

TEST(CameraStatistics, StartsAnewWithAServerThatStartsAnew) {
  CameraStatistics camera;
  camera.received(totals(900, 50), 1000, at(0));
  camera.received(totals(1), 1000, at(100));
  camera.received(totals(2), 1000, at(133));
  EXPECT_EQ(camera.snapshot().totals.captured, 3u);
  EXPECT_EQ(camera.snapshot().dropped, 0u);
}

TEST(CameraStatistics, LeavesNothingUnaccountedWhereTheServerWentOnWithoutUs) {
  CameraStatistics camera;
  camera.connected();
  camera.received(totals(100, 5, 2), 1000, at(0));
  camera.received(totals(101, 5, 2), 1000, at(33));
  // The connection was cut for eight seconds. Frames on their way are lost. Others were not
  // encoded, since there was no client.
  camera.connected();
  camera.received(totals(341, 5, 233), 1000, at(8'033));
  camera.received(totals(343, 6, 233), 1000, at(8'100));
  const auto s = camera.snapshot();
  EXPECT_EQ(s.connections, 2u);
  EXPECT_EQ(s.totals.captured, 5u);
  EXPECT_EQ(s.received, 4u);
  EXPECT_EQ(s.drops.at("encoder_busy"), 1u);
  EXPECT_EQ(s.drops.at("window_full"), 0u);
  EXPECT_EQ(s.drops.at("unaccounted"), 0u);
}

TEST(CameraStatistics, DoesNotAddUpWhatAServerMakesUp) {
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 62;
  CameraStatistics camera;
  camera.connected();
  std::uint64_t captured = 1;
  for (int i = 0; i < 100; ++i) {
    captured += i % 2 ? kHuge : 1;
    camera.received({.captured = captured, .encoder_busy = i % 3 ? 0 : kHuge, .damaged = i % 5 ? 0 : kHuge},
                    10, at(33 * i));
  }
  const auto s = camera.snapshot();
  EXPECT_LE(s.totals.captured, 200u);
  EXPECT_LE(s.totals.encoder_busy, 200u);
  EXPECT_LE(s.totals.damaged, 200u);
}

TEST(CameraStatistics, MeasuresNoLatencyWhereTimesAreNotBelieved) {
  CameraStatistics camera;
  camera.timed(milliseconds(2), {.capture = milliseconds(1)});
  camera.displayed(1, milliseconds(30));
  for (int i = 2; i < 100; ++i) {
    camera.timed(std::nullopt, {.capture = std::chrono::hours(1)});
    camera.displayed(static_cast<std::uint64_t>(i), std::nullopt);
  }
  const auto s = camera.snapshot();
  EXPECT_EQ(s.displayed, 99u);
  EXPECT_EQ(s.times_not_believed, 98u);
  EXPECT_NEAR(s.latency.percentile_ms(99), 30, 0.6);
  EXPECT_NEAR(s.stages[0].percentile_ms(99), 1, 0.05);
}

TEST(CameraStatistics, MeasuresTheRateBetweenFirstAndNewestFrame) {
  CameraStatistics camera;
  camera.received(totals(1), 999999, at(0));
  camera.received(totals(2), 125000, at(500));
  camera.received(totals(3), 125000, at(1000));
  EXPECT_NEAR(camera.snapshot().mbps, 2.0, 1e-9);
}

TEST(ViewStatistics, CountsFromTheFirstCompleteViewOn) {
  ViewStatistics views;
  views.rendered(at(0), at(5), false);
  views.rendered(at(100), at(110), true);
  views.rendered(at(200), at(210), false);
  views.rendered(at(300), at(310), true);
  EXPECT_EQ(views.frames(), 3u);
  EXPECT_NEAR(views.fps(), 10.0, 1e-9);
  EXPECT_NEAR(views.render_time().percentile_ms(50), 10.0, 0.2);
}

TEST(Statistics, WritesEveryKeyOfTheDesign) {
  testing::TemporaryFolder folder;
  CameraStatistics camera;
  camera.received(totals(1), 10, at(0));
  camera.stage(Stage::kWire, milliseconds(2));
  camera.displayed(1, milliseconds(30));
  const std::string path = folder / "stats.json";
  ASSERT_TRUE(write_statistics(path, {{"left", "", camera.snapshot()}}, ViewStatistics(), "cpu", 1280, 720));
  std::ifstream file(path);
  const auto json = nlohmann::json::parse(file);
  const auto& left = json.at("cameras").at(0);
  for (const char* key : {"name", "frames_captured", "frames_received", "frames_dropped", "drops",
                          "frames_unshown", "mbps", "latency_ms", "stages_ms"}) {
    EXPECT_TRUE(left.contains(key)) << key;
  }
  EXPECT_EQ(left.at("last_shown_sequence"), 1);
  EXPECT_NEAR(left.at("latency_ms").at("p95").get<double>(), 30, 0.6);
  EXPECT_NEAR(left.at("stages_ms").at("wire").at("p50").get<double>(), 2, 0.05);
  EXPECT_EQ(json.at("view").at("size"), "1280x720");
  EXPECT_TRUE(json.at("view").contains("render_ms"));
  EXPECT_TRUE(json.at("view").at("skew_ms").contains("p95"));
  EXPECT_EQ(left.at("pictures").at("damaged"), 0);
  EXPECT_EQ(left.at("pictures").at("late"), 0);
  EXPECT_EQ(left.at("frames_shown"), 1);
  EXPECT_TRUE(left.at("left_out").is_null());
  EXPECT_TRUE(json.at("clock").contains("uncertainty_us"));
}

TEST(Statistics, NamesACameraThatIsLeftOutAndWhyInAnyBytes) {
  testing::TemporaryFolder folder;
  const std::string path = folder / "stats.json";
  ASSERT_TRUE(write_statistics(path, {{"\xff:7001", "codec \"h265\" \xc3\x28 is unknown", {}}},
                               ViewStatistics(), "cpu", 2, 2));
  std::ifstream file(path);
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json.at("cameras").at(0).at("name"), "\xef\xbf\xbd:7001");
  EXPECT_NE(json.at("cameras").at(0).at("left_out").get<std::string>().find("h265"), std::string::npos);
}

TEST(Statistics, NamesAFileThatCannotBeWritten) {
  const auto written = write_statistics("/nowhere/stats.json", {}, ViewStatistics(), "cpu", 2, 2);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/nowhere/stats.json"), std::string::npos);
}

}  // namespace
}  // namespace copresence::statistics
