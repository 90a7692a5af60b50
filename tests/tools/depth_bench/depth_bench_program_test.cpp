// The program depth_bench as a person calls it, on recordings out of the ordinary.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "capture_server/recording/oni_writer.h"
#include "tests/support/process.h"

namespace copresence::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;

class DepthBenchProgram : public ::testing::Test {
 protected:
  /// Four frames; `depth` of pixel and frame.
  void record(const std::function<int(int, int)>& depth, DepthUnit unit = DepthUnit::kMillimetre) const {
    recording::OniContent content;
    content.camera.model = {kWidth, kHeight, 58, 58, kWidth / 2.0 - 0.5, kHeight / 2.0 - 0.5, {}};
    content.camera.name = "odd";
    content.camera.unit = unit;
    content.max_depth = 65535;
    content.color = std::nullopt;
    auto writer = recording::OniWriter::create(recording_, content, file::Existing::kReplace);
    ASSERT_TRUE(writer) << writer.error().what;
    for (int frame = 0; frame < 4; ++frame) {
      DepthImage image(kWidth, kHeight);
      for (int i = 0; i < kWidth * kHeight; ++i)
        image.data()[i] = static_cast<std::uint16_t>(depth(i, frame));
      ASSERT_TRUE(writer->write_depth(std::chrono::microseconds(33'333 * (frame + 1)), image));
    }
    ASSERT_TRUE(writer->finish());
  }

  /// Exit code of a run over all codecs; rows() and words_ are what it gave.
  std::optional<int> bench(std::vector<std::string> more) {
    std::vector<std::string> arguments{program("depth_bench"), recording_, "--json", json_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Process process(arguments);
    const auto code = process.wait(std::chrono::seconds(60));
    words_ = process.output();
    return code;
  }

  nlohmann::json rows() const { return nlohmann::json::parse(std::ifstream(json_)); }

  TemporaryFolder folder_;
  std::string recording_ = folder_ / "odd.oni", json_ = folder_ / "rows.json", words_;
};

// These baselines carry no validity mask, so they turn some holes into depth or depth into holes.
bool has_no_mask(const nlohmann::json& row) {
  return row["codec"] == "split16" || row["codec"] == "holoimage";
}

TEST_F(DepthBenchProgram, LeavesOutWhatARecordingDoesNotAllowAndGoesOn) {
  record([](int i, int frame) { return 500 + i + frame; });  // more levels than codes
  ASSERT_EQ(bench({"--codec", "all", "--qp", "0,20", "--kbps", "500"}), 0) << words_;
  EXPECT_THAT(words_, HasSubstr("quantized qp=0: this sensor has more than 1024 depth levels"));
  std::set<std::string> lossless;
  for (const auto& row : rows()) {
    EXPECT_EQ(has_no_mask(row) ? 0 : row["hole_flips"].get<int>(), 0) << row;
    if (row["setting"] == "qp=0") lossless.insert(row["codec"]);
  }
  EXPECT_FALSE(lossless.contains("quantized") || lossless.contains("adaptive"));
  EXPECT_TRUE(lossless.contains("accuracy10"));
  EXPECT_EQ(rows().size(), 3u * 14 - 2 + 5);

  EXPECT_EQ(bench({"--codec", "quantized", "--qp", "0"}), 1);
  EXPECT_THAT(words_, HasSubstr("choose a --depth-qp above 0"));
}

TEST_F(DepthBenchProgram, TakesAnyDepth) {
  const auto holes_only = [](int, int) { return 0; };
  const auto no_hole = [](int i, int frame) { return 1000 + i / 8 + frame; };
  const auto all_values = [](int i, int frame) { return (i * 21 + frame) % 65536; };
  for (const auto& depth : {std::function<int(int, int)>(holes_only), std::function<int(int, int)>(no_hole),
                            std::function<int(int, int)>(all_values)}) {
    for (const DepthUnit unit : {DepthUnit::kMillimetre, DepthUnit::k100Micrometres}) {
      record(depth, unit);
      ASSERT_EQ(bench({"--codec", "all", "--qp", "12", "--kbps", "500"}), 0) << words_;
      EXPECT_EQ(rows().size(), 2u * 14 + 5);
      for (const auto& row : rows()) EXPECT_EQ(has_no_mask(row) ? 0 : row["hole_flips"].get<int>(), 0) << row;
    }
  }
}

TEST_F(DepthBenchProgram, SaysBeforeALongRunThatItsResultHasNoPlace) {
  record([](int i, int) { return 1000 + i / 8; });
  json_ = "/nowhere/rows.json";
  EXPECT_EQ(bench({"--qp", "12"}), 2);
  EXPECT_THAT(words_, HasSubstr("/nowhere"));
}

}  // namespace
}  // namespace copresence::testing
