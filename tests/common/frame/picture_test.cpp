#include "common/frame/picture.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

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

TEST(Picture, IsEmptyOnceItsSamplesHaveMovedAway) {
  Picture from(PixelFormat::kYuv420, 8, 4);
  Picture to = std::move(from);
  EXPECT_TRUE(from.empty());
  EXPECT_TRUE(from.plane8(0).empty());
  EXPECT_EQ(to.plane8(0).size(), 32u);
  from = std::move(to);
  EXPECT_TRUE(to.empty());
  EXPECT_EQ(to.height(), 0);
  EXPECT_EQ(from.plane8(1).size(), 8u);
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

Picture borrow(std::vector<std::uint8_t>& samples, std::shared_ptr<const void> owner) {
  return Picture::borrowed(PixelFormat::kYuv420, 4, 2, {&samples[0], &samples[8], &samples[10]},
                           std::move(owner));
}

TEST(Picture, BorrowsSamplesWithoutACopy) {
  std::vector<std::uint8_t> samples = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const auto owner = std::make_shared<int>();
  {
    const Picture picture = borrow(samples, owner);
    EXPECT_EQ(picture.plane8(0).data(), &samples[0]);
    EXPECT_EQ(picture.plane8(2).data(), &samples[10]);
    EXPECT_EQ(picture.plane8(1).size(), 2u);
    const Picture same = picture;
    EXPECT_EQ(same.plane8(0).data(), &samples[0]);
    EXPECT_EQ(owner.use_count(), 3);
  }
  EXPECT_EQ(owner.use_count(), 1);
}

TEST(Picture, CopiesBorrowedSamplesBeforeItIsWritten) {
  std::vector<std::uint8_t> samples = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const auto owner = std::make_shared<int>();
  Picture picture = borrow(samples, owner);
  const Picture before = picture;
  EXPECT_EQ(picture, before);
  picture.plane8(1)[1] = 99;
  EXPECT_EQ(samples[9], 10);
  EXPECT_NE(picture, before);
  picture.plane8(1)[1] = 10;
  EXPECT_EQ(picture, before);  // nothing else changed
  EXPECT_EQ(owner.use_count(), 2);
}

}  // namespace
}  // namespace copresence
