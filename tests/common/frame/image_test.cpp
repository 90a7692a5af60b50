#include "common/frame/image.h"

#include <gtest/gtest.h>

#include <utility>

namespace copresence {
namespace {

TEST(Image, IsEmptyOnceItsPixelsHaveMovedAway) {
  DepthImage from(4, 2, 7);
  DepthImage to = std::move(from);
  EXPECT_TRUE(from.empty());
  EXPECT_EQ(from.width(), 0);
  EXPECT_EQ(from.height(), 0);
  EXPECT_EQ(to(3, 1), 7);

  DepthImage other(6, 6, 1);
  other = std::move(to);
  EXPECT_EQ(to.width(), 0);
  EXPECT_EQ(to.height(), 0);
  EXPECT_EQ(other.width(), 4);
  EXPECT_EQ(other(0, 0), 7);
}

TEST(Image, CanBeUsedAgainAfterAMove) {
  DepthImage image(4, 2, 7);
  const DepthImage taken = std::move(image);
  image.resize(2, 2);
  image(1, 1) = 3;
  EXPECT_EQ(image(1, 1), 3);
  EXPECT_EQ(taken.pixels().size(), 8u);
}

}  // namespace
}  // namespace copresence
