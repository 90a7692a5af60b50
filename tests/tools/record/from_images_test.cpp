#include "tools/record/from_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_reader.h"
#include "tests/support/recording_scene.h"

namespace copresence::record {
namespace {

using recording::OniReader;
using testing::HasSubstr;
using Kind = recording::RecordedStream::Kind;

const recording::ProgressReport kNobodyWatches = [](double) {};

class FromImages : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_.file("depth"));
    std::filesystem::create_directories(folder_.file("rgb"));
    settings_.folder = folder_.file("");
    settings_.out = folder_.file("made.oni");
    settings_.name = "set";
  }

  void depth(const std::string& name, int value, int width = 64, int height = 48, int type = CV_16UC1) const {
    cv::imwrite(folder_.file("depth/" + name), cv::Mat(height, width, type, cv::Scalar::all(value)));
  }
  void color(const std::string& name, int width = 64, int height = 48) const {
    cv::imwrite(folder_.file("rgb/" + name), cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 100, 200)));
  }
  void lists() const {
    std::ofstream(folder_.file("depth.txt")) << "100.000000 depth/1.png\n100.033333 depth/2.png\n";
    std::ofstream(folder_.file("rgb.txt")) << "100.010000 rgb/1.png\n100.040000 rgb/2.png\n";
  }
  std::string refusal() const {
    const auto made = make_from_images(settings_, kNobodyWatches);
    EXPECT_FALSE(std::filesystem::exists(settings_.out));
    return made ? "made" : made.error().what;
  }

  FromImagesSettings settings_;
  const test::TemporaryFolder folder_;
};

TEST_F(FromImages, MakesARecordingOfATumSet) {
  lists();
  depth("1.png", 5000);
  depth("2.png", 7500);
  color("1.png");
  color("2.png");
  settings_.intrinsics = Intrinsics{52.5, 52.6, 31, 23, {0.1, -0.2}};
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->depth_per_metre, 5000);
  const auto reader = OniReader::open(settings_.out);
  ASSERT_TRUE(reader) << reader.error().what;
  const auto& depth = *reader->summary().find(Kind::kDepth);
  ASSERT_EQ(depth.frames(), 2u);
  EXPECT_EQ(depth.timestamps_us[0], 100'000'000u);
  EXPECT_EQ(depth.timestamps_us[1], 100'033'333u);
  EXPECT_EQ(reader->summary().find(Kind::kColor)->timestamps_us[0], 100'010'000u);
  EXPECT_EQ(*reader->depth(0), DepthImage(64, 48, 1000));
  EXPECT_EQ(*reader->depth(1), DepthImage(64, 48, 1500));
  const Rgb8 pixel = (*reader->color(0))(5, 5);
  EXPECT_NEAR(pixel.r, 200, 8);
  EXPECT_NEAR(pixel.b, 10, 8);
  const auto& note = reader->summary().camera_metadata;
  ASSERT_TRUE(note);
  EXPECT_EQ(note->model.fy, 52.6);
  EXPECT_EQ(note->model.distortion[1], -0.2);
  EXPECT_TRUE(note->registered);
}

TEST_F(FromImages, KeepsMillimetresOfPlainFoldersAndJpegsAsTheyAre) {
  depth("0001.png", 1234);
  color("0001.jpg");
  ASSERT_TRUE(make_from_images(settings_, kNobodyWatches));
  const auto reader = OniReader::open(settings_.out);
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_EQ(*reader->depth(0), DepthImage(64, 48, 1234));
  const auto payload = reader->payload(*reader->summary().find(Kind::kColor), 0);
  EXPECT_EQ(*payload, test::bytes_of(folder_.file("rgb/0001.jpg")));
}

TEST_F(FromImages, TakesTheLargestValueForAHoleAsSevenScenesDoes) {
  depth("1.png", 65535);
  depth("2.png", 65534);
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->too_far, 0u);
  const auto reader = OniReader::open(settings_.out);
  EXPECT_EQ(*reader->depth(0), DepthImage(64, 48, 0));
  EXPECT_EQ(*reader->depth(1), DepthImage(64, 48, 65534));
}

TEST_F(FromImages, TurnsAJpegThatSaysHowItsCameraWasHeld) {
  depth("1.png", 1000, 48, 64);
  std::vector<std::uint8_t> jpeg;
  cv::Mat lying(48, 64, CV_8UC3, cv::Scalar(10, 100, 200));
  lying(cv::Rect(0, 0, 32, 48)).setTo(cv::Scalar(200, 100, 10));  // its left half is blue
  cv::imencode(".jpg", lying, jpeg);
  // "Exif", big-endian TIFF, one entry: orientation (0x112) 6, to be turned clockwise.
  const char exif[] =
      "\xFF\xE1\0\x22"
      "Exif\0\0MM\0*\0\0\0\x08\0\1\1\x12\0\3\0\0\0\1\0\6\0\0\0\0\0\0";
  jpeg.insert(jpeg.begin() + 2, std::begin(exif), std::end(exif) - 1);
  std::ofstream(folder_.file("rgb/1.jpg"), std::ios::binary)
      .write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  const auto picture = OniReader::open(settings_.out)->color(0);
  ASSERT_TRUE(picture) << picture.error().what;
  EXPECT_EQ(picture->width(), 48);
  EXPECT_GT((*picture)(24, 8).b, 150);
  EXPECT_GT((*picture)(24, 56).r, 150);
}

TEST_F(FromImages, CountsDepthThatTheUnitDoesNotHold) {
  depth("1.png", 60000);
  settings_.unit = DepthUnit::k100Micrometres;
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->too_far, 64u * 48u);
  EXPECT_EQ(*OniReader::open(settings_.out)->depth(0), DepthImage(64, 48, 0));
}

TEST_F(FromImages, TakesColorOfAnotherSizeAsAnotherCameras) {
  depth("1.png", 1000);
  color("1.png", 128, 96);
  ASSERT_TRUE(make_from_images(settings_, kNobodyWatches));
  const auto summary = recording::check(settings_.out);
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_FALSE(summary->camera_metadata->registered);
  ASSERT_TRUE(summary->camera_metadata->color);
  EXPECT_EQ(summary->camera_metadata->color->model.width, 128);
  EXPECT_NEAR(summary->camera_metadata->color->model.fx, 2 * summary->camera_metadata->model.fx, 1e-9);
}

TEST_F(FromImages, GivesPicturesOfEveryShapeSquarePixels) {
  for (const auto& [width, height] : {std::pair{96, 54}, std::pair{48, 64}, std::pair{80, 64}}) {
    depth("1.png", 1000, width, height);
    color("1.png", 2 * width, 2 * height);
    const auto report = make_from_images(settings_, kNobodyWatches);
    ASSERT_TRUE(report) << report.error().what;
    EXPECT_THAT(report->remarks, testing::Contains(HasSubstr("square pixels")));
    const auto note = recording::check(settings_.out)->camera_metadata;
    EXPECT_DOUBLE_EQ(note->model.fx, note->model.fy);
    EXPECT_NEAR(note->model.fx, 575.8 * std::max(width, height) / 640, 0.1);
    EXPECT_DOUBLE_EQ(note->color->model.fx, note->color->model.fy);
    settings_.overwrite = true;
  }
}

TEST_F(FromImages, CropsOddSizesByOnePixelAndSaysSo) {
  depth("1.png", 1000, 65, 49);
  color("1.jpg", 65, 49);
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(report->remarks, testing::Contains(HasSubstr("64x48 remain")));
  const auto reader = OniReader::open(settings_.out);
  EXPECT_EQ(*reader->depth(0), DepthImage(64, 48, 1000));
  EXPECT_EQ(reader->color(0)->width(), 64);
}

TEST_F(FromImages, ReadsDepthWithExchangedBytes) {
  cv::Mat ramp(48, 64, CV_16UC1);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int mm = 1000 + 3 * x + y;
      ramp.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(mm << 8 | mm >> 8);
    }
  }
  cv::imwrite(folder_.file("depth/1.png"), ramp);
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(report->remarks, testing::Contains(HasSubstr("exchanged")));
  EXPECT_EQ((*OniReader::open(settings_.out)->depth(0))(10, 20), 1000 + 30 + 20);
}

TEST_F(FromImages, ReadsAKinectsRawDisparities) {
  // NYU Depth v2: 16-bit PGM, little-endian against its format, 2047 where nothing was seen.
  std::string pgm = "P5\n64 48\n65535\n";
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int raw = x < 8 ? 2047 : 700 + x;
      pgm += static_cast<char>(raw & 0xff);
      pgm += static_cast<char>(raw >> 8);
    }
  }
  std::ofstream(folder_.file("d-1294886362.665769-1.pgm"), std::ios::binary) << pgm;
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(report->remarks, testing::Contains(HasSubstr("raw disparity")));
  const auto depth = *OniReader::open(settings_.out)->depth(0);
  EXPECT_EQ(depth(0, 0), 0);
  EXPECT_NEAR(depth(30, 5), 351.3 / (1092.5 - 730) * 1000, 1);
}

TEST_F(FromImages, ReadsFloatingPointDepthInMetres) {
  std::string pfm = "Pf\n64 48\n-1.0\n";
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const float metres = y == 0 ? 1.5f : 2.0f;  // the lowest row comes first
      pfm.append(reinterpret_cast<const char*>(&metres), sizeof(metres));
    }
  }
  std::ofstream(folder_.file("depth/1.pfm"), std::ios::binary) << pfm;
  const auto report = make_from_images(settings_, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  const auto depth = *OniReader::open(settings_.out)->depth(0);
  EXPECT_EQ(depth(5, 47), 1500);
  EXPECT_EQ(depth(5, 5), 2000);
}

TEST_F(FromImages, LooksAtAnImagesSizeBeforeItUnpacksIt) {
  // A PNG header that claims 30,000 x 30,000 pixels, and nothing behind it.
  const unsigned char png[] = {0x89, 'P',  'N', 'G', '\r', '\n', 0x1a, '\n', 0,    0, 0,
                               13,   'I',  'H', 'D', 'R',  0,    0,    0x75, 0x30, 0, 0,
                               0x75, 0x30, 16,  0,   0,    0,    0,    0,    0,    0, 0};
  std::ofstream(folder_.file("depth/1.png"), std::ios::binary)
      .write(reinterpret_cast<const char*>(png), sizeof(png));
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("1.png"), HasSubstr("30000x30000")));
}

TEST_F(FromImages, NeverOverwritesAFileUnasked) {
  depth("1.png", 1000);
  std::ofstream(settings_.out) << "precious";
  const auto made = make_from_images(settings_, kNobodyWatches);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, testing::AllOf(HasSubstr("made.oni"), HasSubstr("--overwrite")));
  EXPECT_EQ(std::filesystem::file_size(settings_.out), 8u);
  settings_.overwrite = true;
  EXPECT_TRUE(make_from_images(settings_, kNobodyWatches));
}

TEST_F(FromImages, KnowsWhenADatedSetBegan) {
  lists();
  for (const char* name : {"1.png", "2.png"}) {
    depth(name, 5000);
    color(name);
  }
  std::ofstream(folder_.file("depth.txt")) << "1650000000.25 depth/1.png\n1650000000.283 depth/2.png\n";
  std::ofstream(folder_.file("rgb.txt")) << "1650000000.25 rgb/1.png\n1650000000.283 rgb/2.png\n";
  ASSERT_TRUE(make_from_images(settings_, kNobodyWatches));
  const auto summary = recording::check(settings_.out);
  ASSERT_TRUE(summary) << summary.error().what;
  ASSERT_TRUE(summary->unix_zero_us);
  EXPECT_EQ(*summary->unix_zero_us + static_cast<std::int64_t>(summary->find(Kind::kDepth)->timestamps_us[0]),
            1650000000250000);
}

TEST_F(FromImages, WritesNothingThatCannotBePlayed) {
  depth("1.png", 1000, 4096, 4096);
  EXPECT_THAT(refusal(), HasSubstr("4096x4096"));
  for (const char* name : {"1.png", "2.png", "3.png"}) depth(name, 1000);
  settings_.intrinsics = Intrinsics{1e-300, 52, 31, 23, {}};
  EXPECT_NE(refusal(), "made");
  settings_.intrinsics.reset();
  settings_.times = TimeUnit::kSeconds;
  std::ofstream(folder_.file("depth.txt")) << "0.0 depth/1.png\n20.0 depth/2.png\n40.0 depth/3.png\n";
  EXPECT_THAT(refusal(), HasSubstr("every 20 s"));
  std::ofstream(folder_.file("depth.txt")) << "0.0 depth/1.png\n1e12 depth/2.png\n2e12 depth/3.png\n";
  EXPECT_THAT(refusal(), HasSubstr("thousand years"));
}

TEST_F(FromImages, NamesTheImageThatIsWrong) {
  depth("1.png", 100, 64, 48, CV_8UC3);
  EXPECT_THAT(refusal(), HasSubstr("3 channels of 8 bits"));
  depth("1.png", 100);
  depth("2.png", 100, 32, 24);
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("2.png"), HasSubstr("32x24")));
  std::ofstream(folder_.file("depth/2.png")) << "no image";
  EXPECT_THAT(refusal(), HasSubstr("depth/2.png"));
}

}  // namespace
}  // namespace copresence::record
