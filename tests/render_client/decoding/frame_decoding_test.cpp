#include "render_client/decoding/frame_decoding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "capture_server/encoding/frame_encoding.h"

namespace copresence::decoding {
namespace {

using std::chrono::milliseconds;

constexpr int kWidth = 160, kHeight = 120;
constexpr Rgb8 kOrange{220, 120, 40};

bool is_near(const Rgb8& a, const Rgb8& b) {
  constexpr int kCoding = 12;  // of 255; greatest change by video coding
  return std::abs(a.r - b.r) < kCoding && std::abs(a.g - b.g) < kCoding && std::abs(a.b - b.b) < kCoding;
}

/// A stream of a wall. Some frames have no colour.
class MissingColor : public testing::Test {
 protected:
  void SetUp() override {
    sensor::SensorDescription sensor;
    sensor.depth = {kWidth, kHeight, 146, 146, 80, 60, {}};
    sensor.color = sensor.depth;
    sensor.has_color = true;
    sensor.registered = true;
    auto encoding = server::FrameEncoding::open(sensor, nullptr, {});
    ASSERT_TRUE(encoding) << encoding.error().what;
    encoding_.emplace(std::move(*encoding));
    auto decoding = FrameDecoding::open(encoding_->description());
    ASSERT_TRUE(decoding) << decoding.error().what;
    decoding_.emplace(std::move(*decoding));
  }

  /// The next frame, decoded as by the client. It was captured `at` after the beginning.
  RgbdFrame next(milliseconds at, std::optional<Rgb8> color) {
    RgbdFrame frame;
    frame.metadata.sequence = ++sequence_;
    frame.metadata.captured_at = Instant(std::chrono::seconds(1000) + at);
    frame.depth = DepthImage(kWidth, kHeight, 2000);
    frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
    if (color) frame.color.emplace(kWidth, kHeight, *color);
    auto encoded = encoding_->encode(std::move(frame), sequence_ == 1);
    EXPECT_TRUE(encoded) << encoded.error().what;
    FrameDecoding::Durations durations;
    auto decoded = decoding_->decode(*encoded, durations);
    EXPECT_TRUE(decoded) << decoded.error().what;
    return decoded ? std::move(*decoded) : RgbdFrame{};
  }

  std::optional<server::FrameEncoding> encoding_;
  std::optional<FrameDecoding> decoding_;
  std::uint64_t sequence_ = 0;
};

TEST_F(MissingColor, IsReplacedByTheNewestPicture) {
  next(milliseconds(0), Rgb8{20, 40, 220});
  const RgbdFrame orange = next(milliseconds(33), kOrange);
  RgbdFrame without = next(milliseconds(66), std::nullopt);
  ASSERT_FALSE(without.color);
  EXPECT_TRUE(decoding_->repeat_color(without));
  ASSERT_TRUE(without.color);
  EXPECT_EQ(*without.color, *orange.color);
  EXPECT_TRUE(is_near((*without.color)(80, 60), kOrange));
}

TEST_F(MissingColor, StaysMissingWhereTheNewestPictureIsTooOld) {
  next(milliseconds(0), kOrange);
  RgbdFrame late = next(FrameDecoding::kLongestRepeat, std::nullopt);
  EXPECT_TRUE(decoding_->repeat_color(late));
  RgbdFrame too_late = next(FrameDecoding::kLongestRepeat + milliseconds(33), std::nullopt);
  EXPECT_FALSE(decoding_->repeat_color(too_late));
  EXPECT_FALSE(too_late.color);
}

TEST_F(MissingColor, StaysMissingBeforeTheFirstPicture) {
  RgbdFrame first = next(milliseconds(0), std::nullopt);
  EXPECT_FALSE(decoding_->repeat_color(first));
  EXPECT_FALSE(first.color);
}

TEST_F(MissingColor, AFrameWithColorKeepsItsOwn) {
  next(milliseconds(0), Rgb8{20, 40, 220});
  RgbdFrame orange = next(milliseconds(33), kOrange);
  EXPECT_FALSE(decoding_->repeat_color(orange));
  EXPECT_TRUE(is_near((*orange.color)(80, 60), kOrange));
}

}  // namespace
}  // namespace copresence::decoding
