// Views with a known difference to the truth.

#include "tools/view_bench/view_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace copresence::view_bench {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr Rgb8 kGray{100, 100, 100};

class ViewErrorTest : public ::testing::Test {
 protected:
  ViewErrorTest() {
    eye_.intrinsics = camera_from_field_of_view(kWidth, kHeight, 1.0);
    true_.color = ColorImage(kWidth, kHeight, kGray);
    true_.depth_m = Image<float>(kWidth, kHeight, 2.0F);
    camera_.model = camera_from_field_of_view(640, 480, 1.5);
    camera_.range = {0.4, 5};
    view_.width = kWidth;
    view_.height = kHeight;
    view_.color = Image<Rgba8>(kWidth, kHeight, {100, 100, 100, 255});
    view_.depth_m = Image<float>(kWidth, kHeight, 2.0F);
    view_.camera = Image<std::uint8_t>(kWidth, kHeight, 0);
    view_.origin = Image<renderer::Origin>(kWidth, kHeight, renderer::Origin::kSeen);
  }

  TrueEyeView truth() const { return describe_truth(true_, eye_, std::span(&camera_, 1)); }

  void set(int x, Rgba8 color, renderer::Origin origin) {
    for (int y = 0; y < kHeight; ++y) {
      view_.color(x, y) = color;
      view_.origin(x, y) = origin;
      if (origin != renderer::Origin::kSeen) view_.camera(x, y) = renderer::kNoCamera;
    }
  }

  simulation::TrueView true_;
  renderer::ViewPose eye_;
  ViewVolume camera_;
  renderer::MergedView view_;
};

TEST_F(ViewErrorTest, CountsEveryReachablePixelByItsOrigin) {
  for (int x = 0; x < kWidth / 2; ++x) set(x, {0, 0, 0, 0}, renderer::Origin::kEmpty);
  for (int x = kWidth / 2; x < 3 * kWidth / 4; ++x) set(x, {110, 110, 110, 255}, renderer::Origin::kExtended);
  ViewError error;
  error.add(truth(), view_, false);
  const ViewScore score = error.score();
  EXPECT_NEAR(score.empty_percent, 50, 1e-9);
  EXPECT_NEAR(score.extended_percent, 25, 1e-9);
  EXPECT_NEAR(score.seen_percent, 25, 1e-9);
  EXPECT_NEAR(score.psnr_extended, 20 * std::log10(255.0 / 10), 1e-9);
  // Half of the pixels are off by 100, a quarter by 10.
  EXPECT_NEAR(score.psnr, 10 * std::log10(255.0 * 255 / (0.5 * 100 * 100 + 0.25 * 10 * 10)), 1e-9);
}

TEST_F(ViewErrorTest, LeavesOutWhatNoCameraCouldHaveShown) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) true_.depth_m(x, y) = 6.0F;  // beyond the camera's range
  }
  for (int x = 0; x < kWidth / 2; ++x) set(x, {0, 0, 0, 0}, renderer::Origin::kEmpty);
  ViewError error;
  error.add(truth(), view_, false);
  EXPECT_EQ(error.score().empty_percent, 0);
  EXPECT_EQ(error.score().seen_percent, 100);
}

TEST_F(ViewErrorTest, MeasuresStepsBetweenCamerasOnFlatSurfaces) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      view_.camera(x, y) = 1;
      view_.color(x, y) = {108, 108, 108, 255};
    }
  }
  ViewError error;
  error.add(truth(), view_, false);
  EXPECT_NEAR(error.score().seam_step, 8, 0.01);
}

TEST_F(ViewErrorTest, CountsNoStepsBesideRememberedPixels) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      view_.camera(x, y) = 1;
      view_.color(x, y) = {108, 108, 108, 255};
      view_.origin(x, y) = renderer::Origin::kRemembered;
    }
  }
  ViewError error;
  error.add(truth(), view_, false);
  EXPECT_TRUE(std::isnan(error.score().seam_step));
}

TEST_F(ViewErrorTest, CountsNoStepsWhereTheViewShowsAnotherSurface) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      view_.camera(x, y) = 1;
      view_.color(x, y) = {108, 108, 108, 255};
      view_.depth_m(x, y) = 1.8F;
    }
  }
  ViewError error;
  error.add(truth(), view_, false);
  EXPECT_TRUE(std::isnan(error.score().seam_step));
}

// The true surface has a thin bright line near the border between the cameras.
TEST_F(ViewErrorTest, CountsNoStepsAtColorEdges) {
  for (int y = 0; y < kHeight; ++y) {
    true_.color(kWidth / 2 + 1, y) = {200, 200, 200};
    for (int x = kWidth / 2; x < kWidth; ++x) view_.camera(x, y) = 1;
    view_.color(kWidth / 2 + kSeamPixels - 1, y) = {200, 200, 200, 255};
  }
  ViewError error;
  error.add(truth(), view_, false);
  EXPECT_TRUE(std::isnan(error.score().seam_step));
}

TEST_F(ViewErrorTest, MeasuresTheErrorWhereSomethingMoves) {
  constexpr int kFrom = 20, kTo = 30;
  Image<float> earlier = true_.depth_m;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kFrom; x < kTo; ++x) earlier(x, y) = 1.0F;
  }
  TrueEyeView truth = this->truth();
  truth.is_moving = moving_region(true_.depth_m, earlier);
  EXPECT_FALSE(truth.is_moving(kFrom - kMovingPixels - 1, 5));
  EXPECT_TRUE(truth.is_moving(kFrom - kMovingPixels, 5));
  EXPECT_TRUE(truth.is_moving(kTo - 1 + kMovingPixels, 5));
  EXPECT_FALSE(truth.is_moving(kTo + kMovingPixels, 5));
  for (int x = kFrom - kMovingPixels; x < kTo + kMovingPixels; ++x)
    set(x, {110, 110, 110, 255}, renderer::Origin::kSeen);
  ViewError error;
  error.add(truth, view_, false);
  EXPECT_NEAR(error.score().psnr_moving, 20 * std::log10(255.0 / 10), 1e-9);
}

TEST_F(ViewErrorTest, MeasuresFlickerWhereTheTruthIsStill) {
  ViewError error;
  error.add(truth(), view_, false);
  for (int x = 0; x < kWidth; ++x) set(x, {104, 104, 104, 255}, renderer::Origin::kSeen);
  error.add(truth(), view_, true);
  EXPECT_NEAR(error.score().flicker, 4, 0.01);
}

TEST_F(ViewErrorTest, FindsThePixelsNearDepthEdges) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) true_.depth_m(x, y) = 3.0F;
  }
  const TrueEyeView view = truth();
  const int edge = kWidth / 2;
  EXPECT_TRUE(view.at_silhouette(edge - kSilhouettePixels, 5));
  EXPECT_FALSE(view.at_silhouette(edge - kSilhouettePixels - 2, 5));
  EXPECT_TRUE(view.at_silhouette(edge + kSilhouettePixels - 1, 5));
  EXPECT_FALSE(view.at_silhouette(edge + kSilhouettePixels + 1, 5));
}

}  // namespace
}  // namespace copresence::view_bench
