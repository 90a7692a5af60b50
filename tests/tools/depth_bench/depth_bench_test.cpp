#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/depth/depth_codec.h"
#include "tests/common/depth/scenes.h"
#include "tools/depth_bench/baselines.h"
#include "tools/depth_bench/codec_run.h"
#include "tools/depth_bench/depth_error.h"
#include "tools/depth_bench/rvl.h"

namespace copresence::depth_bench {
namespace {

using depth::testing::flat_scene;
using depth::testing::kinect_scene;

DepthRecording recording(int frames) {
  DepthRecording made;
  made.format = {64, 48, DepthUnit::kMillimetre, {}};
  for (int time = 0; time < frames; ++time) {
    auto scene = kinect_scene(64, 48, time);
    made.depth.push_back(scene.depth);
    made.states.push_back(scene.state);
  }
  return made;
}

TEST(DepthError, KnowsAnErrorWhenItSeesOne) {
  const auto wall = flat_scene(16, 8, 2000);
  DepthImage back = wall.depth;
  StateImage states = wall.state;
  back(3, 3) = 2012;  // One step is 11.4 mm here.
  back(4, 4) = 1800;
  states(5, 5) = DepthState::kHole;
  DepthError error(DepthUnit::kMillimetre);
  error.add(wall.depth, wall.state, back, states);
  EXPECT_DOUBLE_EQ(error.rmse_mm(), std::sqrt((12.0 * 12 + 200.0 * 200) / 128));
  EXPECT_DOUBLE_EQ(error.mae_mm(), 212.0 / 128);
  EXPECT_DOUBLE_EQ(error.max_mm(), 200);
  EXPECT_DOUBLE_EQ(error.percent_beyond_3_steps(), 100.0 / 128);
  EXPECT_DOUBLE_EQ(error.percent_beyond_100mm(), 100.0 / 128);
  EXPECT_DOUBLE_EQ(error.percentile_mm(0.5), 0);
  EXPECT_NEAR(error.percentile_mm(0.99), 12, 0.01);
  EXPECT_EQ(error.hole_flips(), 1u);
}

TEST(DepthError, CountsPointsBetweenTwoSurfacesAsFlying) {
  auto edge = flat_scene(16, 8, 1000);
  for (int y = 0; y < 8; ++y) {
    for (int x = 8; x < 16; ++x) edge.depth(x, y) = 3000;
  }
  DepthError clean(DepthUnit::kMillimetre), flying(DepthUnit::kMillimetre);
  clean.add(edge.depth, edge.state, edge.depth, edge.state);
  EXPECT_EQ(clean.percent_flying(), 0);
  DepthImage back = edge.depth;
  for (int y = 0; y < 8; ++y) back(8, y) = 2000;
  flying.add(edge.depth, edge.state, back, edge.state);
  EXPECT_DOUBLE_EQ(flying.percent_flying(), 25) << "one of the four columns at the edge";
}

TEST(Rvl, BringsBackWhatItWasGiven) {
  for (const auto& depth :
       {kinect_scene(64, 48).depth, DepthImage(8, 8, 0), DepthImage(8, 8, 65535), DepthImage(2, 2, 1)}) {
    DepthImage back(depth.width(), depth.height());
    decode_rvl(encode_rvl(depth.pixels()), back.pixels());
    EXPECT_EQ(back, depth);
  }
}

TEST(Rvl, WritesTheNibblesOfThePaper) {
  // No zeros (0), two values (2): 5 is zigzag 10 = 0b1010: 2 with more, 1; 4 is -1, zigzag 1.
  const std::array<std::uint16_t, 2> depth{5, 4};
  EXPECT_EQ(encode_rvl(depth), (std::vector<std::uint8_t>{0x00, 0x10, 0xa1, 0x02}));
}

TEST(Baselines, ThatAreLosslessLoseNothing) {
  for (const std::string name : {"rvl", "rvl_zstd", "png"}) {
    const auto row = run_baseline(recording(3), name);
    ASSERT_TRUE(row);
    EXPECT_EQ(row->codec, name);
    EXPECT_EQ(row->max_mm, 0);
    EXPECT_EQ(row->hole_flips, 0u);
    EXPECT_GT(row->mbps, 0);
  }
  EXPECT_TRUE(run_baseline(recording(3), "split16"));
  EXPECT_TRUE(run_baseline(recording(3), "holoimage"));
}

TEST(CodecRun, NeverFlipsAHoleAndIsExactWithoutLoss) {
  for (const std::string_view codec : depth::codec_names()) {
    const auto row = run_codec(recording(3), std::string(codec), {.qp = 20, .kbps = std::nullopt});
    ASSERT_TRUE(row) << row.error().what;
    EXPECT_EQ(row->hole_flips, 0u) << codec;
    EXPECT_EQ(row->frames, 3);
  }
  for (const std::string codec : {"quantized", "adaptive"}) {
    const auto row = run_codec(recording(3), codec, {.qp = 0, .kbps = std::nullopt});
    ASSERT_TRUE(row) << row.error().what;
    EXPECT_EQ(row->max_mm, 0);
  }
}

// A far wall with bumps. From the fourth frame on, a near surface with bumps moves in front of it.
DepthRecording near_surface_enters(int frames) {
  DepthRecording made;
  made.format = {160, 120, DepthUnit::kMillimetre, {}};
  for (int time = 0; time < frames; ++time) {
    auto scene = flat_scene(160, 120, 3000);
    std::minstd_rand random(static_cast<unsigned>(time) + 1);
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const bool near = time > 2 && x > 40 + time;
        const double bumps = std::sin((x - time) * 0.4) * std::cos(y * 0.3);
        const double z = near ? 900 + 2 * y + 60 * bumps : 2500 + 8 * x + 150 * bumps;
        scene.depth(x, y) = depth::testing::kinect_level(z + (random() % 4 == 0 ? z * z / 351300 : 0));
      }
    }
    made.depth.push_back(scene.depth);
    made.states.push_back(scene.state);
  }
  return made;
}

TEST(CodecRun, AdaptiveIsWithin5PercentOfTheLeastErrorWhereANearSurfaceEnters) {
  const DepthRecording moving = near_surface_enters(30);
  for (const int kbps : {200, 400, 800}) {
    const auto error = [&](const std::string& codec) {
      const auto row = run_codec(moving, codec, {.qp = std::nullopt, .kbps = kbps});
      EXPECT_TRUE(row) << row.error().what;
      return row ? row->rmse_steps : 0;
    };
    EXPECT_LE(error("adaptive"), 1.05 * std::min(error("quantized"), error("accuracy10"))) << kbps;
  }
}

TEST(Rows, AreTheJsonThatTheDesignNames) {
  const auto path = std::filesystem::temp_directory_path() / "copresence_depth_bench_test.json";
  const auto row = run_codec(recording(2), "quantized", {.qp = std::nullopt, .kbps = 500});
  ASSERT_TRUE(row) << row.error().what;
  ASSERT_TRUE(write_json({*row}, path.string()));
  const auto list = nlohmann::json::parse(std::ifstream(path));
  std::filesystem::remove(path);
  ASSERT_EQ(list.size(), 1u);
  for (const char* key :
       {"codec", "pixel_format", "setting", "mbps", "mask_mbps", "rmse_mm", "rmse_steps", "mae_mm", "p50_mm",
        "p99_mm", "max_mm", "p99_steps", "percent_beyond_3_steps", "percent_beyond_100mm", "hole_flips",
        "encode_ms", "decode_ms", "max_frame_kb", "frames"}) {
    EXPECT_TRUE(list[0].contains(key)) << key;
  }
  EXPECT_EQ(list[0]["setting"], "kbps=500");
  EXPECT_EQ(list[0]["pixel_format"], "gray10");
}

}  // namespace
}  // namespace copresence::depth_bench
