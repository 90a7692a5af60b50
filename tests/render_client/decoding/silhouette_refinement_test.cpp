#include "render_client/decoding/silhouette_refinement.h"

#include <gtest/gtest.h>

namespace copresence::decoding {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::uint16_t kPost = 1500, kWall = 3000;
constexpr Rgb8 kPostColor{200, 40, 30}, kWallColor{60, 120, 180};

bool is_post(int x, int y, int shift) {
  return x >= 20 + shift && x < 40 + shift && y >= 12 + shift && y < 36 + shift;
}

/// A post before a wall. Its depth is `shift` pixels to the lower right of its colour.
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

void refine(RgbdFrame& frame) {
  SilhouetteRefinement().apply(frame, DepthUnit::kMillimetre, kKinectV1Noise);
}

/// Pixels whose depth is that of one surface and whose colour is that of the other.
int contradictions(const RgbdFrame& frame) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) count += frame.depth(x, y) != (is_post(x, y, 0) ? kPost : kWall);
  }
  return count;
}

TEST(SilhouetteRefinement, MovesDepthEdgesToTheColorEdgesBesideThem) {
  for (int shift = -2; shift <= 2; ++shift) {
    RgbdFrame frame = post(shift);
    const int before = contradictions(frame);
    refine(frame);
    EXPECT_EQ(before > 0, shift != 0);
    // The corner itself is no edge in its row and column.
    EXPECT_LE(contradictions(frame), 2 * shift * shift) << shift;
  }
}

TEST(SilhouetteRefinement, ClosesAGapOnTheSideThatItsColorBelongsTo) {
  RgbdFrame frame = post(0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 36; x < 44; ++x) make_hole(frame, x, y);
  }
  refine(frame);
  for (int y = 12; y < 36; ++y) {
    for (int x = 36; x < 44; ++x) {
      ASSERT_EQ(frame.depth(x, y), x < 40 ? kPost : kWall) << x << ' ' << y;
      ASSERT_EQ(frame.state(x, y), DepthState::kFilled);
    }
  }
}

TEST(SilhouetteRefinement, MarksPixelsThatItMovesAndNoOthers) {
  const RgbdFrame before = post(2);
  RgbdFrame frame = before;
  refine(frame);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool moved = frame.depth(x, y) != before.depth(x, y);
      ASSERT_EQ(frame.state(x, y), moved ? DepthState::kFilled : DepthState::kMeasured);
    }
  }
}

TEST(SilhouetteRefinement, LeavesSurfacesOfTheSameColorAlone) {
  RgbdFrame frame = post(2, {70, 125, 175});
  make_hole(frame, 42, 20);
  const DepthImage before = frame.depth;
  refine(frame);
  EXPECT_EQ(frame.depth, before);
}

TEST(SilhouetteRefinement, LeavesAFrameWithoutColorAlone) {
  RgbdFrame frame = post(2);
  frame.color.reset();
  const DepthImage before = frame.depth;
  refine(frame);
  EXPECT_EQ(frame.depth, before);
}

TEST(SilhouetteRefinement, LeavesColorEdgesOnOneSurfaceAlone) {
  RgbdFrame frame = post(0);
  frame.depth = DepthImage(kWidth, kHeight, kWall);
  refine(frame);
  EXPECT_EQ(frame.depth, DepthImage(kWidth, kHeight, kWall));
}

TEST(SilhouetteRefinement, TakesPicturesOfAnySize) {
  for (const auto& [width, height] : {std::pair{2, 2}, {8, 2}, {2, 10}, {18, 6}}) {
    RgbdFrame frame;
    frame.depth = DepthImage(width, height, kWall);
    frame.state = StateImage(width, height, DepthState::kMeasured);
    frame.color = ColorImage(width, height, kWallColor);
    frame.depth(width / 2, height / 2) = kPost;
    (*frame.color)(width / 2, height / 2) = kPostColor;
    refine(frame);
    EXPECT_EQ(frame.depth(0, 0), kWall);
  }
}

}  // namespace
}  // namespace copresence::decoding
