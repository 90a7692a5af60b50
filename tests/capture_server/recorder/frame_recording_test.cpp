#include "capture_server/recorder/frame_recording.h"

#include <gtest/gtest.h>

#include "capture_server/recording/oni_reader.h"
#include "tests/support/recording_scene.h"

namespace copresence::server {
namespace {

using recording::OniReader;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Kind = recording::RecordedStream::Kind;

TEST(RecordingClock, KeepsTheSensorsOwnTimes) {
  RecordingClock clock;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(clock.offset_for(microseconds(205 + 33'333 * i), Instant(milliseconds(33 * i))).count(), 0);
  }
}

TEST(RecordingClock, GoesOnWhereACameraBeginsToCountAnew) {
  RecordingClock clock;
  EXPECT_EQ(clock.offset_for(seconds(100), Instant(seconds(7))).count(), 0);
  const microseconds offset = clock.offset_for(microseconds(0), Instant(seconds(9)));
  EXPECT_EQ(offset, seconds(102));  // two seconds unplugged
  EXPECT_EQ(clock.offset_for(microseconds(33'333), Instant(seconds(9) + milliseconds(33))), offset);
}

TEST(RecordingClock, MakesNothingOfTimesThatMakeNoSense) {
  RecordingClock clock;
  const microseconds nonsense(std::int64_t{1} << 60);
  EXPECT_EQ(nonsense + clock.offset_for(nonsense, Instant()), microseconds(0));
  RecordingClock other;
  EXPECT_EQ(microseconds(-5) + other.offset_for(microseconds(-5), Instant()), microseconds(0));
  EXPECT_EQ(nonsense + other.offset_for(nonsense, Instant(seconds(1))), microseconds(seconds(1)));
}

class FrameRecordingTest : public testing::Test {
 protected:
  void SetUp() override {
    sensor_.depth = {64, 48, 58, 58, 31.5, 23.5, {}};
    sensor_.color = sensor_.depth;
    sensor_.has_color = true;
    sensor_.registered = true;
  }

  RgbdFrame frame(int i) const {
    RgbdFrame frame;
    frame.metadata.sequence = static_cast<std::uint64_t>(i + 1);
    frame.metadata.captured_at = Instant(milliseconds(33 * i));
    frame.depth = scene_.depth_of(i);
    frame.color = scene_.color_of(i);
    frame.sensor_times = {microseconds(1'000'000 + 33'333 * i), microseconds(1'007'000 + 33'333 * i), false};
    return frame;
  }

  std::string path() const { return folder_.file("a.oni"); }

  sensor::SensorDescription sensor_;
  const test::RecordingScene scene_;
  const test::TemporaryFolder folder_;
};

TEST_F(FrameRecordingTest, HoldsEveryDepthBitByBitAndBothStreamsTimes) {
  auto recording = FrameRecording::open(path(), sensor_, "left");
  ASSERT_TRUE(recording) << recording.error().what;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(recording->write(frame(i)));
  ASSERT_TRUE(recording->finish());
  const auto reader = OniReader::open(path());
  ASSERT_TRUE(reader) << reader.error().what;
  const auto& depth = *reader->summary().find(Kind::kDepth);
  ASSERT_EQ(depth.frames(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(*reader->depth(i), scene_.depth_of(static_cast<int>(i)));
    EXPECT_EQ(depth.timestamps_us[i], 1'000'000u + 33'333 * i);
    EXPECT_EQ(reader->summary().find(Kind::kColor)->timestamps_us[i], 1'007'000u + 33'333 * i);
  }
  EXPECT_EQ(reader->summary().find(Kind::kColor)->codec, "JPEG");
  EXPECT_EQ(reader->summary().camera_metadata->name, "left");
  EXPECT_TRUE(reader->summary().camera_metadata->registered);
}

TEST_F(FrameRecordingTest, TakesDepthsBeyondTenMetres) {
  auto recording = FrameRecording::open(path(), sensor_, "left");
  RgbdFrame far = frame(0);
  far.depth = DepthImage(64, 48, 65535);
  ASSERT_TRUE(recording->write(far));
  ASSERT_TRUE(recording->finish());
  EXPECT_EQ(*OniReader::open(path())->depth(0), far.depth);
}

TEST_F(FrameRecordingTest, WritesAColorPictureThatIsShownAgainOnce) {
  auto recording = FrameRecording::open(path(), sensor_, "left");
  RgbdFrame again = frame(1);
  again.sensor_times.color = frame(0).sensor_times.color;
  again.sensor_times.color_is_repeated = true;
  ASSERT_TRUE(recording->write(frame(0)) && recording->write(again));
  ASSERT_TRUE(recording->finish());
  const auto summary = recording::check(path());
  EXPECT_EQ(summary->find(Kind::kDepth)->frames(), 2u);
  EXPECT_EQ(summary->find(Kind::kColor)->frames(), 1u);
}

TEST_F(FrameRecordingTest, GoesOnThroughACameraThatIsPluggedInAgain) {
  auto recording = FrameRecording::open(path(), sensor_, "left");
  RgbdFrame later = frame(1);
  later.metadata.captured_at = Instant(seconds(2));
  later.sensor_times = {microseconds(100), microseconds(90), false};
  ASSERT_TRUE(recording->write(frame(0)));
  ASSERT_TRUE(recording->write(later)) << "its clock began anew";
  ASSERT_TRUE(recording->finish());
  EXPECT_EQ(recording::check(path())->find(Kind::kDepth)->timestamps_us[1], 3'000'000u);
}

TEST_F(FrameRecordingTest, KeepsTheColorCameraWhereItIsNotTheDepthCamera) {
  sensor_.registered = false;
  sensor_.color = {128, 96, 110, 110, 63.5, 47.5, {}};
  sensor_.color_from_depth = Rigid3{Eigen::Matrix3d::Identity(), {0.025, 0, 0}};
  auto recording = FrameRecording::open(path(), sensor_, "left");
  ASSERT_TRUE(recording) << recording.error().what;
  RgbdFrame with_large_color = frame(0);
  with_large_color.color = ColorImage(128, 96);
  ASSERT_TRUE(recording->write(with_large_color));
  ASSERT_TRUE(recording->finish());
  const auto note = recording::check(path())->camera_metadata;
  ASSERT_TRUE(note && note->color);
  EXPECT_EQ(note->color->model, sensor_.color);
  EXPECT_EQ(note->color->color_from_depth, sensor_.color_from_depth);
}

TEST_F(FrameRecordingTest, NeverOverwritesARecording) {
  for (const char* name : {"a.oni", "a-2.oni", "a-3.oni"}) {
    auto recording = FrameRecording::open(path(), sensor_, "left");
    ASSERT_TRUE(recording);
    EXPECT_EQ(recording->path(), folder_.file(name));
    ASSERT_TRUE(recording->write(frame(0)));
    ASSERT_TRUE(recording->finish());
  }
}

TEST_F(FrameRecordingTest, NotesWhenItBeganByTheClock) {
  auto recording = FrameRecording::open(path(), sensor_, "left");
  ASSERT_TRUE(recording);
  RgbdFrame first = frame(0);
  first.metadata.captured_at = std::chrono::steady_clock::now() - seconds(2);
  const auto captured = std::chrono::system_clock::now() - seconds(2);
  ASSERT_TRUE(recording->write(first));
  ASSERT_TRUE(recording->finish());
  const auto summary = recording::check(path());
  ASSERT_TRUE(summary) << summary.error().what;
  ASSERT_TRUE(summary->unix_zero_us);
  const microseconds began(*summary->unix_zero_us + 1'000'000);  // its first frame's time
  EXPECT_NEAR(std::chrono::duration<double>(began - captured.time_since_epoch()).count(), 0, 0.5);
}

TEST_F(FrameRecordingTest, ACopyKeepsTheStartOfTheOriginal) {
  sensor_.unix_zero_us = 1'650'000'000'000'000;
  auto recording = FrameRecording::open(path(), sensor_, "left");
  ASSERT_TRUE(recording);
  ASSERT_TRUE(recording->write(frame(0)));
  ASSERT_TRUE(recording->finish());
  EXPECT_EQ(recording::check(path())->unix_zero_us, 1'650'000'000'000'000);
}

TEST_F(FrameRecordingTest, SaysWhereItCannotWrite) {
  const auto nowhere = FrameRecording::open("/nonexistent/a.oni", sensor_, "left");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().what.find("/nonexistent/a.oni"), std::string::npos);
  EXPECT_FALSE(FrameRecording::open("/dev/full", sensor_, "left"));
}

}  // namespace
}  // namespace copresence::server
