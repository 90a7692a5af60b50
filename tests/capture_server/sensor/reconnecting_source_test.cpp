#include "capture_server/sensor/reconnecting_source.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;

// A camera that gives `frames` frames and then fails.
class ShortCamera final : public FrameSource {
 public:
  ShortCamera(SensorDescription description, std::uint64_t frames, ErrorCode then)
      : description_(std::move(description)), frames_(frames), then_(then) {}
  const SensorDescription& description() const override { return description_; }
  SourceCounters counters() const override { return {given_, 1, 0, 0}; }
  Result<RgbdFrame> next(std::stop_token) override {
    if (given_ == frames_) return fail(then_, "gone");
    RgbdFrame frame;
    frame.metadata.sequence = ++given_;
    return frame;
  }

 private:
  const SensorDescription description_;
  const std::uint64_t frames_;
  const ErrorCode then_;
  std::uint64_t given_ = 0;
};

SensorDescription sized(int width) {
  SensorDescription description;
  description.name = "camera";
  description.depth.width = width;
  return description;
}

Result<std::unique_ptr<FrameSource>> camera(std::uint64_t frames, ErrorCode then, int width = 640) {
  return std::make_unique<ShortCamera>(sized(width), frames, then);
}

TEST(ReconnectingSource, CountsOnWhenItsCameraIsBack) {
  int opened = 0;
  const auto source = ReconnectingSource::open(
      [&]() -> Result<std::unique_ptr<FrameSource>> {
        if (++opened == 2) return fail(ErrorCode::kNotFound, "not there yet");
        return camera(3, opened == 1 ? ErrorCode::kUnavailable : ErrorCode::kTimeout);
      },
      milliseconds(1));
  ASSERT_TRUE(source);
  std::vector<std::uint64_t> sequences;
  int away = 0;
  while (sequences.size() < 7) {
    const auto frame = (*source)->next({});
    if (frame) {
      sequences.push_back(frame->metadata.sequence);
    } else {
      EXPECT_EQ(frame.error().code, away == 1 ? ErrorCode::kUnavailable : frame.error().code);
      ++away;
    }
  }
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(away, 3);  // gone, not there yet, silent
  EXPECT_EQ((*source)->counters().frames, 7u);
  EXPECT_EQ((*source)->counters().depth_without_color, 3u);
}

TEST(ReconnectingSource, IsAMistakeWhereItWasNeverThere) {
  const auto source = ReconnectingSource::open(
      []() -> Result<std::unique_ptr<FrameSource>> { return fail(ErrorCode::kNotFound, "no such camera"); });
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
}

TEST(ReconnectingSource, TakesNoOtherCameraInItsPlace) {
  int width = 640;
  const auto source =
      ReconnectingSource::open([&] { return camera(1, ErrorCode::kUnavailable, width); }, milliseconds(1));
  ASSERT_TRUE(source);
  EXPECT_TRUE((*source)->next({}));
  EXPECT_FALSE((*source)->next({}));
  width = 320;
  EXPECT_EQ((*source)->next({}).error().code, ErrorCode::kUnsupported);
}

TEST(ReconnectingSource, StopsWaitingWhenAskedTo) {
  bool there = true;
  const auto source = ReconnectingSource::open(
      [&]() -> Result<std::unique_ptr<FrameSource>> {
        if (there) return camera(0, ErrorCode::kUnavailable);
        return fail(ErrorCode::kNotFound, "away");
      },
      std::chrono::seconds(60));
  ASSERT_TRUE(source);
  there = false;
  EXPECT_FALSE((*source)->next({}));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ((*source)->next(stop.get_token()).error().code, ErrorCode::kEndOfStream);
}

}  // namespace
}  // namespace copresence::sensor
