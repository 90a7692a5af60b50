#include "capture_server/sensor/recording_track.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

TEST(RecordingTrack, MissesNothingWhereEveryPictureComes) {
  RecordingTrack track(3, 90);
  for (std::uint64_t i = 0; i < 9; ++i) {
    EXPECT_EQ(track.advance(1 + i % 3, static_cast<std::int64_t>(30 * (i % 3))), 0u);
    EXPECT_EQ(track.timestamp_us(), static_cast<std::int64_t>(30 * i));
    EXPECT_EQ(track.at_end(), i % 3 == 2);
  }
  EXPECT_EQ(track.pass(), 2u);
}

TEST(RecordingTrack, CountsWhatIsMissingInTheMiddleAndOverTheSeam) {
  RecordingTrack track(5, 50);
  EXPECT_EQ(track.advance(2, 10), 1u);
  EXPECT_EQ(track.advance(4, 30), 1u);
  EXPECT_EQ(track.advance(3, 20), 3u);  // the fifth, and the first two of the next pass
  EXPECT_EQ(track.timestamp_us(), 70);
}

TEST(RecordingTrack, CountsPassesOfWhichNothingCame) {
  RecordingTrack track(4, 40);
  EXPECT_EQ(track.begin_pass(0), 0u);
  EXPECT_EQ(track.begin_pass(2), 8u);
  EXPECT_EQ(track.begin_pass(1), 0u);
  EXPECT_EQ(track.advance(3, 20), 2u);
  EXPECT_EQ(track.timestamp_us(), 100);
  EXPECT_EQ(track.begin_pass(3), 1u);
  EXPECT_EQ(track.advance(1, 0), 0u);
  EXPECT_EQ(track.pass(), 3u);
}

TEST(RecordingTrack, NeverGoesBackInTime) {
  RecordingTrack track(2, 10);
  track.advance(1, 8);
  track.advance(2, 3);
  EXPECT_EQ(track.timestamp_us(), 8);
}

}  // namespace
}  // namespace copresence::sensor
