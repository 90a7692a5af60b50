// Exported folders, and the recordings that from-images makes of them again.

#include "tools/record/image_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "capture_server/recording/oni_reader.h"
#include "capture_server/recording/oni_writer.h"
#include "tests/support/recording_scene.h"
#include "tools/record/export_folder.h"
#include "tools/record/from_images.h"

namespace copresence::record {
namespace {

using recording::OniReader;
using testing::HasSubstr;
using Kind = recording::RecordedStream::Kind;

const recording::ProgressReport kNobodyWatches = [](double) {};

std::string text_of(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class ImageExport : public testing::TestWithParam<DepthUnit> {
 protected:
  static constexpr int kFrames = 6;

  /// A recording with a pose, JPEG colour and a start time.
  void write() const {
    scene_.unit = GetParam();
    recording::OniContent content;
    content.camera.model = {64, 48, 58.25, 57.5, 31, 23, {0.1, -0.2, 0, 0, 0.5, 0, 0, 0}};
    content.camera.name = "left";
    content.camera.registered = true;
    content.camera.unit = scene_.unit;
    content.camera.world_from_camera.emplace();
    content.camera.world_from_camera->rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    content.camera.world_from_camera->translation << 1.5, 2, -3;
    content.color = recording::ColorCoding::kJpeg;
    content.unix_zero_us = 1'700'000'000'000'000;
    auto writer = recording::OniWriter::create(folder_.file("a.oni"), content);
    ASSERT_TRUE(writer) << writer.error().what;
    for (int i = 0; i < kFrames; ++i) {
      const std::chrono::microseconds time(33'333 * (i + 1));
      ASSERT_TRUE(writer->write_depth(time, scene_.depth_of(i)));
      ASSERT_TRUE(writer->write_color(time + std::chrono::milliseconds(7), scene_.color_of(i)));
    }
    ASSERT_TRUE(writer->finish());
  }

  /// Exports the recording and makes it again.
  void there_and_back(ExportFormat format) const {
    write();
    const auto exported = export_images(
        {.recording = folder_.file("a.oni"), .out = folder_.file("out"), .format = format}, kNobodyWatches);
    ASSERT_TRUE(exported) << exported.error().what;
    EXPECT_EQ(exported->depth_images, static_cast<std::size_t>(kFrames));
    EXPECT_EQ(exported->color_images, static_cast<std::size_t>(kFrames));
    FromImagesSettings settings;
    settings.folder = folder_.file("out");
    settings.out = folder_.file("b.oni");
    const auto made = make_from_images(settings, kNobodyWatches);
    ASSERT_TRUE(made) << made.error().what;
    const auto a = OniReader::open(folder_.file("a.oni")), b = OniReader::open(folder_.file("b.oni"));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(*a->summary().camera_metadata, *b->summary().camera_metadata);
    const auto &color_a = *a->summary().find(Kind::kColor), &color_b = *b->summary().find(Kind::kColor);
    ASSERT_EQ(color_b.frames(), static_cast<std::size_t>(kFrames));
    for (std::size_t i = 0; i < kFrames; ++i) {
      EXPECT_EQ(*a->depth(i), *b->depth(i)) << i;
      EXPECT_EQ(*a->payload(color_a, i), *b->payload(color_b, i)) << "JPEG files are copied unchanged";
      if (format != ExportFormat::kTum) continue;
      EXPECT_EQ(start(*a, Kind::kDepth, i), start(*b, Kind::kDepth, i));
      EXPECT_EQ(start(*a, Kind::kColor, i), start(*b, Kind::kColor, i));
    }
  }

  static std::int64_t start(const OniReader& reader, Kind kind, std::size_t frame) {
    return reader.summary().unix_zero_us.value_or(0) +
           static_cast<std::int64_t>(reader.summary().find(kind)->timestamps_us[frame]);
  }

  mutable test::RecordingScene scene_;
  const test::TemporaryFolder folder_;
};

TEST_P(ImageExport, FromImagesReadsATumFolderBackTheSame) {
  there_and_back(ExportFormat::kTum);
}

TEST_P(ImageExport, FromImagesReadsA7ScenesFolderBackTheSame) {
  there_and_back(ExportFormat::k7Scenes);
}

TEST_P(ImageExport, HasTheFilesOfTheFormats) {
  write();
  ExportSettings settings{.recording = folder_.file("a.oni"), .out = folder_.file("tum")};
  ASSERT_TRUE(export_images(settings, kNobodyWatches));
  const std::filesystem::path tum = settings.out;
  EXPECT_THAT(text_of(tum / "depth.txt"), HasSubstr("1700000000.033333 depth/1700000000.033333.png\n"));
  EXPECT_THAT(text_of(tum / "rgb.txt"), HasSubstr("1700000000.040333 rgb/1700000000.040333.jpg\n"));
  // A turn by 90 degrees about z is the quaternion (0, 0, 0.707, 0.707).
  EXPECT_THAT(text_of(tum / "groundtruth.txt"), HasSubstr("1700000000.033333 1.5 2 -3 0 0 0.70710"));
  const cv::Mat depth = cv::imread((tum / "depth/1700000000.033333.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_16UC1);
  const int per_unit = GetParam() == DepthUnit::kMillimetre ? 5 : 1;
  EXPECT_EQ(depth.at<std::uint16_t>(0, 1), scene_.depth_of(0)(1, 0) * per_unit);
  EXPECT_EQ(depth.at<std::uint16_t>(0, 0), 0);

  settings.out = folder_.file("scenes");
  settings.format = ExportFormat::k7Scenes;
  ASSERT_TRUE(export_images(settings, kNobodyWatches));
  const std::filesystem::path scenes = settings.out;
  EXPECT_EQ(text_of(scenes / "frame-000005.pose.txt"),
            "0\t-1\t0\t1.5\n1\t0\t0\t2\n0\t0\t1\t-3\n0\t0\t0\t1\n");
  EXPECT_TRUE(std::filesystem::exists(scenes / "frame-000005.color.jpg"));
  EXPECT_FALSE(std::filesystem::exists(scenes / "frame-000006.depth.png"));
}

TEST_P(ImageExport, OverwritesNothing) {
  write();
  const ExportSettings settings{.recording = folder_.file("a.oni"), .out = folder_.file("")};
  const auto exported = export_images(settings, kNobodyWatches);
  ASSERT_FALSE(exported);
  EXPECT_THAT(exported.error().what, HasSubstr("is not empty"));
}

INSTANTIATE_TEST_SUITE_P(Units, ImageExport,
                         testing::Values(DepthUnit::kMillimetre, DepthUnit::k100Micrometres));

TEST(ExportedCamera, ThatIsDamagedIsNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.file("camera.json")) << "{\"depth_per_metre\": 5000}";
  const auto camera = read_exported_camera(folder.file(""));
  ASSERT_FALSE(camera);
  EXPECT_THAT(camera.error().what, HasSubstr("camera.json"));
}

}  // namespace
}  // namespace copresence::record
