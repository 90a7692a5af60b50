#include "common/frame/picture.h"

#include <gtest/gtest.h>

namespace copresence {
namespace {

TEST(Picture, HasThePlanesOfItsFormat) {
  const Picture gray(PixelFormat::kGray8, 8, 4);
  EXPECT_EQ(gray.planes(), 1);
  EXPECT_EQ(gray.plane8(0).size(), 32u);

  const Picture deep(PixelFormat::kGray10, 8, 4);
  EXPECT_EQ(deep.plane10().size(), 32u);

  const Picture halved(PixelFormat::kYuv420, 8, 4);
  EXPECT_EQ(halved.plane8(0).size(), 32u);
  EXPECT_EQ(halved.plane8(1).size(), 8u);
  EXPECT_EQ(halved.plane8(2).size(), 8u);

  const Picture full(PixelFormat::kYuv444, 8, 4);
  EXPECT_EQ(full.plane8(2).size(), 32u);
}

TEST(Picture, KeepsPlanesApart) {
  Picture picture(PixelFormat::kYuv420, 4, 4);
  for (int i = 0; i < 3; ++i) {
    for (auto& sample : picture.plane8(i)) sample = static_cast<std::uint8_t>(10 + i);
  }
  for (int i = 0; i < 3; ++i) {
    for (auto sample : picture.plane8(i)) EXPECT_EQ(sample, 10 + i);
  }
}

}  // namespace
}  // namespace copresence
