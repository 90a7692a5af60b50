#include "render_client/decoding/silhouette_colors.h"

#include <gtest/gtest.h>

namespace copresence::decoding {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::uint16_t kPost = 1500, kWall = 3000;
constexpr Rgb8 kPostColor{200, 40, 30}, kWallColor{60, 120, 180};

bool is_post(int x, int y, int shift) {
  return x >= 20 + shift && x < 40 + shift && y >= 12 + shift && y < 36 + shift;
}

/// A post in front of a wall. Its depth is `shift` pixels to the lower right of its colour.
RgbdFrame post(int shift, Rgb8 post_color = kPostColor) {
  RgbdFrame frame;
  frame.depth = DepthImage(kWidth, kHeight);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  frame.color = ColorImage(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      frame.depth(x, y) = is_post(x, y, shift) ? kPost : kWall;
      (*frame.color)(x, y) = is_post(x, y, 0) ? post_color : kWallColor;
    }
  }
  return frame;
}

void make_hole(RgbdFrame& frame, int x, int y) {
  frame.depth(x, y) = 0;
  frame.state(x, y) = DepthState::kHole;
}

void separate(RgbdFrame& frame) {
  SilhouetteColors().apply(frame, DepthUnit::kMillimetre, kKinectV1Noise);
}

/// Returns the number of pixels with the depth of the wall and the colour of the post.
int painted_on_the_wall(const RgbdFrame& frame) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      count += frame.depth(x, y) == kWall && (*frame.color)(x, y) == kPostColor;
  }
  return count;
}

TEST(SilhouetteColors, TheFarSideOfADepthEdgeNeverCarriesTheNearSidesColor) {
  for (int shift = -2; shift <= 2; ++shift) {
    RgbdFrame frame = post(shift);
    const DepthImage depth = frame.depth;
    const int before = painted_on_the_wall(frame);
    separate(frame);
    EXPECT_EQ(before > 0, shift != 0);
    // Pixels at a corner of the post's colour may have no depth edge in their row or column.
    EXPECT_LE(painted_on_the_wall(frame), shift * shift) << shift;
    EXPECT_EQ(frame.depth, depth);
  }
}

TEST(SilhouetteColors, HolesBesideASurfaceInFrontDoNotCarryItsColor) {
  for (const int gap : {6, 20}) {
    RgbdFrame frame = post(0);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 38; x < 38 + gap; ++x) make_hole(frame, x, y);
    }
    separate(frame);
    for (int y = 12; y < 36; ++y) {
      for (int x = 38; x < 38 + gap; ++x) ASSERT_EQ((*frame.color)(x, y), kWallColor) << x << ' ' << y;
    }
  }
}

TEST(SilhouetteColors, LeavesSurfacesOfTheSameColorAlone) {
  RgbdFrame frame = post(2, {70, 125, 175});
  make_hole(frame, 42, 20);
  const ColorImage before = *frame.color;
  separate(frame);
  EXPECT_EQ(*frame.color, before);
}

TEST(SilhouetteColors, LeavesColorEdgesOnOneSurfaceAlone) {
  RgbdFrame frame = post(0);
  frame.depth = DepthImage(kWidth, kHeight, kWall);
  const ColorImage before = *frame.color;
  separate(frame);
  EXPECT_EQ(*frame.color, before);
}

TEST(SilhouetteColors, TakesFramesWithoutColorAndOfAnySize) {
  for (const auto& [width, height] : {std::pair{2, 2}, {8, 2}, {2, 10}, {18, 6}}) {
    RgbdFrame frame;
    frame.depth = DepthImage(width, height, kWall);
    frame.state = StateImage(width, height, DepthState::kMeasured);
    frame.depth(width / 2, height / 2) = kPost;
    separate(frame);
    EXPECT_FALSE(frame.color);
    frame.color = ColorImage(width, height, kWallColor);
    separate(frame);
    EXPECT_EQ(*frame.color, ColorImage(width, height, kWallColor));
  }
}

}  // namespace
}  // namespace copresence::decoding
