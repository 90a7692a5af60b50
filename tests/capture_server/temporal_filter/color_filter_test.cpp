#include "capture_server/temporal_filter/color_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace copresence::temporal_filter {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// Luma with a gradient and some texture, reduced by `darker`, in 1/255.
Picture scene(double darker = 0) {
  Picture picture(PixelFormat::kYuv420, kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double luma = 60 + x / 2.0 + y / 2.0 + 20 * ((x / 4 + y / 4) % 2) - darker;
      picture.plane8(0)[static_cast<std::size_t>(y * kWidth + x)] =
          static_cast<std::uint8_t>(std::lround(luma));
    }
  }
  for (int plane : {1, 2}) std::ranges::fill(picture.plane8(plane), std::uint8_t{110});
  return picture;
}

void fill(Picture& picture, int left, int top, int right, int bottom, std::uint8_t luma) {
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) picture.plane8(0)[static_cast<std::size_t>(y * kWidth + x)] = luma;
  }
}

double rmse(const Picture& a, const Picture& b, int plane = 0) {
  double squares = 0;
  for (std::size_t i = 0; i < a.plane8(plane).size(); ++i) {
    const double error = a.plane8(plane)[i] - b.plane8(plane)[i];
    squares += error * error;
  }
  return std::sqrt(squares / static_cast<double>(a.plane8(plane).size()));
}

class ColorFilterTest : public ::testing::Test {
 protected:
  Picture with_grain(Picture picture) {
    std::normal_distribution<double> luma(0, 3), chroma(0, 1.5);
    for (int plane = 0; plane < 3; ++plane) {
      for (std::uint8_t& sample : picture.plane8(plane)) {
        const double noise = plane == 0 ? luma(random_) : chroma(random_);
        sample = static_cast<std::uint8_t>(std::clamp(std::lround(sample + noise), 0L, 255L));
      }
    }
    return picture;
  }
  Picture show(Picture picture) {
    filter_.apply(picture, false);
    return picture;
  }
  Picture show_still(int frames) {
    Picture shown;
    for (int i = 0; i < frames; ++i) shown = show(with_grain(scene()));
    return shown;
  }

  std::minstd_rand random_{1};
  ColorFilter filter_;
};

TEST_F(ColorFilterTest, PassesTheFirstFrameUnchanged) {
  const Picture picture = with_grain(scene());
  EXPECT_EQ(show(picture), picture);
}

TEST_F(ColorFilterTest, RemovesTheGrainOfAStillScene) {
  const Picture shown = show_still(60);
  EXPECT_LT(rmse(shown, scene()), rmse(with_grain(scene()), scene()) / 3);
  EXPECT_LT(rmse(shown, scene(), 1), rmse(with_grain(scene()), scene(), 1) / 2);
}

TEST_F(ColorFilterTest, ShowsAHandAtOnceAndThatItIsGone) {
  show_still(60);
  Picture hand = scene();
  fill(hand, 40, 30, 70, 60, 220);
  const Picture with_hand = with_grain(hand), shown = show(with_hand);
  for (int y = 30; y < 60; ++y) {
    for (int x = 40; x < 70; ++x) {
      const auto at = static_cast<std::size_t>(y * kWidth + x);
      ASSERT_EQ(shown.plane8(0)[at], with_hand.plane8(0)[at]);
    }
  }
  EXPECT_LT(rmse(show(with_grain(scene())), scene()), 3) << "no ghost";
}

TEST_F(ColorFilterTest, DoesNotSmearFaintTextureThatMoves) {
  show_still(60);
  for (int i = 0; i < 30; ++i) {
    Picture picture = scene();
    for (int y = 32; y < 96; ++y) {
      for (int x = 40; x < 104; ++x)
        picture.plane8(0)[static_cast<std::size_t>(y * kWidth + x)] = (x + 2 * i) / 6 % 2 ? 120 : 130;
    }
    const Picture shown = show(with_grain(picture));
    double contrast = 0;
    for (int y = 40; y < 88; ++y) {
      for (int x = 48; x < 96; ++x) {
        const auto at = static_cast<std::size_t>(y * kWidth + x);
        contrast += (picture.plane8(0)[at] - 125) * (shown.plane8(0)[at] - 125) / (25.0 * 48 * 48);
      }
    }
    ASSERT_GT(contrast, 0.9) << "frame " << i;
  }
}

TEST_F(ColorFilterTest, FollowsALampThatIsDimmedSlowly) {
  for (const double a_frame : {0.05, 0.2, 1.0}) {
    filter_ = ColorFilter();
    show_still(60);
    double worst = 0;
    for (int i = 1; i <= 40; ++i) {
      const Picture truth = scene(a_frame * i), shown = show(with_grain(truth));
      double mean = 0;
      for (std::size_t at = 0; at < shown.plane8(0).size(); ++at)
        mean += (shown.plane8(0)[at] - truth.plane8(0)[at]) / static_cast<double>(kWidth * kHeight);
      worst = std::max(worst, std::abs(mean));
    }
    EXPECT_LT(worst, 1.5) << a_frame << " of 255 in a frame";
  }
}

TEST_F(ColorFilterTest, AMovingCameraPassesUnchanged) {
  show_still(60);
  for (int i = 0; i < 10; ++i) {
    Picture moved(PixelFormat::kYuv420, kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const int there = x + 5 + 3 * i;
        moved.plane8(0)[static_cast<std::size_t>(y * kWidth + x)] =
            static_cast<std::uint8_t>(60 + 40 * ((there / 4 + y / 4) % 2));
      }
    }
    const Picture picture = with_grain(moved);
    ASSERT_EQ(show(picture), picture) << i;
  }
}

TEST_F(ColorFilterTest, StartsAgainWhenTheSizeChanges) {
  for (const auto& [width, height] : {std::pair{2, 2}, std::pair{70, 50}, std::pair{14, 10}}) {
    for (int i = 0; i < 3; ++i) {
      const Picture picture(PixelFormat::kYuv420, width, height);
      EXPECT_EQ(show(picture), picture);
    }
  }
}

}  // namespace
}  // namespace copresence::temporal_filter
