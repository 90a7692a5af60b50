#include "render_client/statistics.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;

Instant at(int ms) {
  return Instant(milliseconds(ms));
}

TEST(CameraStatistics, CountsFromTheFirstFrameOn) {
  CameraStatistics camera;
  camera.received(500, 20, 3, 1000, at(0));
  camera.decoded();
  const auto s = camera.snapshot();
  EXPECT_EQ(s.captured, 1u);
  EXPECT_EQ(s.dropped, 0u);
  EXPECT_EQ(s.mbps, 0.0);
}

TEST(CameraStatistics, TellsWhyFramesAreMissing) {
  CameraStatistics camera;
  camera.received(100, 7, 40, 1000, at(0));
  camera.received(104, 9, 41, 1000, at(100));  // three are missing: two of them for want of an encoder
  camera.received(105, 9, 41, 1000, at(200));
  camera.not_decoded();
  const auto s = camera.snapshot();
  EXPECT_EQ(s.captured, 6u);
  EXPECT_EQ(s.received, 3u);
  EXPECT_EQ(s.drops.at("encoder_busy"), 2u);
  EXPECT_EQ(s.drops.at("window_full"), 1u);
  EXPECT_EQ(s.drops.at("decode_error"), 1u);
  EXPECT_EQ(s.drops.at("unaccounted"), 0u);
  EXPECT_EQ(s.dropped, 4u);
}

TEST(CameraStatistics, SaysSoWhereAFrameIsMissingThatNobodyKnowsOf) {
  CameraStatistics camera;
  camera.received(100, 0, 0, 1000, at(0));
  camera.received(103, 1, 0, 1000, at(100));
  EXPECT_EQ(camera.snapshot().drops.at("unaccounted"), 1u);
}

TEST(CameraStatistics, CountsPicturesWithoutAPartnerFromTheFirstFrameOn) {
  CameraStatistics camera;
  camera.sensor({10, 20, 30, 40});
  camera.sensor({11, 20, 33, 55});
  camera.sensor({0, 0, 0, 0});  // a server that started anew
  camera.sensor({2, 1, 0, 4});
  const Pictures pictures = camera.snapshot().pictures;
  EXPECT_EQ(pictures.depth_without_color, 3u);
  EXPECT_EQ(pictures.color_without_depth, 1u);
  EXPECT_EQ(pictures.damaged, 3u);
  EXPECT_EQ(pictures.dark, 19u);
}

TEST(CameraStatistics, StartsAnewWithAServerThatStartsAnew) {
  CameraStatistics camera;
  camera.received(900, 50, 0, 1000, at(0));
  camera.received(1, 0, 0, 1000, at(100));
  camera.received(2, 0, 0, 1000, at(133));
  EXPECT_EQ(camera.snapshot().captured, 3u);
  EXPECT_EQ(camera.snapshot().dropped, 0u);
}

TEST(CameraStatistics, MeasuresTheRateBetweenFirstAndNewestFrame) {
  CameraStatistics camera;
  camera.received(1, 0, 0, 999999, at(0));
  camera.received(2, 0, 0, 125000, at(500));
  camera.received(3, 0, 0, 125000, at(1000));
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
  camera.received(1, 0, 0, 10, at(0));
  camera.stage(Stage::kWire, milliseconds(2));
  camera.shown(1, milliseconds(30));
  const std::string path = folder / "stats.json";
  ASSERT_TRUE(write_statistics(path, {"left"}, {camera.snapshot()}, ViewStatistics(), "cpu", 1280, 720));
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
  EXPECT_EQ(left.at("frames_shown"), 1);
  EXPECT_TRUE(json.at("clock").contains("uncertainty_us"));
}

TEST(Statistics, NamesAFileThatCannotBeWritten) {
  const auto written = write_statistics("/nowhere/stats.json", {}, {}, ViewStatistics(), "cpu", 2, 2);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/nowhere/stats.json"), std::string::npos);
}

}  // namespace
}  // namespace copresence::client
