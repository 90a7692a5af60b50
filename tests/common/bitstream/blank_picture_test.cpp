#include "common/bitstream/blank_picture.h"

#include <gtest/gtest.h>

#include "common/bitstream/access_unit.h"
#include "common/video/picture_decoder.h"

namespace copresence::bitstream {
namespace {

int sample(const Picture& picture, std::size_t i) {
  return picture.format() == PixelFormat::kGray10 ? picture.plane10()[i] : picture.plane8(0)[i];
}

TEST(FlatPicture, IsMidGreyToEveryH264Decoder) {
  for (const PixelFormat format : {PixelFormat::kGray8, PixelFormat::kGray10}) {
    for (const auto& [width, height] : {std::pair{640, 480}, {2, 2}, {162, 118}, {1920, 1080}}) {
      BlankPictureWriter writer(format, width, height);
      video::PictureDecoder decoder = video::PictureDecoder::open(format, width, height).value();
      for (int i = 0; i < 40; ++i) {
        const auto picture = decoder.decode(writer.write(i == 0 || i == 20 || i == 21));
        ASSERT_TRUE(picture) << picture.error().what << ' ' << i;
        const auto size = static_cast<std::size_t>(width) * height;
        for (std::size_t k = 0; k < size; k += 97) {
          ASSERT_EQ(sample(*picture, k), format == PixelFormat::kGray10 ? 512 : 128) << k << " of " << i;
        }
      }
    }
  }
}

TEST(FlatPicture, TakesNextToNoBytes) {
  BlankPictureWriter writer(PixelFormat::kGray10, 640, 480);
  EXPECT_LT(writer.write(true).size(), 1200u);
  for (int i = 0; i < 20; ++i) EXPECT_LT(writer.write(false).size(), 16u);
}

}  // namespace
}  // namespace copresence::bitstream
