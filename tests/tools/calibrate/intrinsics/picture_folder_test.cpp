#include "tools/calibrate/intrinsics/picture_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/process.h"
#include "tools/pictures/picture_header.h"

namespace copresence::calibrate {
namespace {

using ::testing::HasSubstr;

// Dark on the left, light on the right.
cv::Mat halves(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar(20, 20, 20));
  picture.colRange(width / 2, width).setTo(cv::Scalar(220, 220, 220));
  return picture;
}

class PictureFolders : public ::testing::Test {
 protected:
  void png(const std::string& name, int width, int height) {
    cv::imwrite(folder_ / name, halves(width, height));
  }

  // Writes an EXIF orientation in either byte order; 0 for no EXIF.
  void jpeg(const std::string& name, int width, int height, unsigned char orientation,
            bool big_endian = true) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", halves(width, height), bytes);
    const unsigned char o = orientation;
    const std::vector<unsigned char> big{0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0,    0,    'M', 'M',
                                         0,    42,   0, 0,  0,   8,   0,   1,   0x01, 0x12, 0,   3,
                                         0,    0,    0, 1,  0,   o,   0,   0,   0,    0,    0,   0};
    const std::vector<unsigned char> little{0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0,    0,    'I', 'I',
                                            42,   0,    8, 0,  0,   0,   1,   0,   0x12, 0x01, 3,   0,
                                            1,    0,    0, 0,  o,   0,   0,   0,   0,    0,    0,   0};
    const auto& exif = big_endian ? big : little;
    if (orientation != 0) bytes.insert(bytes.begin() + 2, exif.begin(), exif.end());
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  std::string refusal() {
    const auto folder = open_picture_folder(folder_ / "");
    return folder ? "accepted" : folder.error().what;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(PictureFolders, TakeJpegsAsTheSensorSawThemWhateverTheirOrientation) {
  jpeg("a.jpg", 64, 48, 0);
  jpeg("b.jpg", 64, 48, 6);
  jpeg("c.JPG", 64, 48, 8, false);
  jpeg("d.jpeg", 64, 48, 3);
  EXPECT_EQ(pictures::read_header(folder_ / "b.jpg")->orientation, 6);
  EXPECT_EQ(pictures::read_header(folder_ / "c.JPG")->orientation, 8);
  const auto folder = open_picture_folder(folder_ / "");
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(folder->files.size(), 4u);
  EXPECT_THAT(folder->remark, HasSubstr("3 of 4 pictures have an orientation"));
  for (const auto& file : folder->files) {
    const auto picture = load_picture(*folder, file);
    ASSERT_TRUE(picture) << picture.error().what;
    EXPECT_EQ(picture->width(), 64);
    EXPECT_LT(picture->data()[0].r, 60) << file;
    EXPECT_GT(picture->data()[63].r, 180) << file;
  }
}

TEST_F(PictureFolders, OfOddSizesLoseTheirLastColumnAndRow) {
  png("a.png", 241, 181);
  png("b.png", 241, 181);
  png("._b.png", 10, 10);  // macOS creates such files.
  const auto folder = open_picture_folder(folder_ / "");
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(folder->files.size(), 2u);
  EXPECT_EQ(folder->width, 240);
  EXPECT_EQ(folder->height, 180);
  EXPECT_THAT(folder->remark, HasSubstr("the last column and row of 241x181 pixels is left out"));
  EXPECT_EQ(load_picture(*folder, folder->files[0])->height(), 180);
}

TEST_F(PictureFolders, OfATelephonesSizeAreTaken) {
  png("a.png", 4000, 3000);
  const auto folder = open_picture_folder(folder_ / "");
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(folder->width, 4000);
}

TEST_F(PictureFolders, OfDifferentSizesAreRefusedByName) {
  png("a.png", 64, 48);
  png("b.png", 64, 48);
  png("c.png", 48, 64);
  EXPECT_THAT(refusal(),
              HasSubstr("c.png has 48x64 pixels, the others 64x48: a program has turned the picture"));
  png("c.png", 32, 24);
  EXPECT_THAT(refusal(), HasSubstr("all must be of one camera"));
}

TEST_F(PictureFolders, NoneAndOtherFilesAreRefused) {
  EXPECT_THAT(refusal(), HasSubstr("no PNG or JPEG pictures"));
  std::ofstream(folder_ / "a.png") << "no picture";
  EXPECT_THAT(refusal(), HasSubstr("a.png: not an image that is read here"));
}

TEST_F(PictureFolders, RefuseAHugePictureByItsHeader) {
  // A header of 30 000 x 30 000 pixels without picture data.
  const std::array<unsigned char, 33> png{0x89, 'P',  'N', 'G', '\r', '\n', 0x1a, '\n', 0,    0, 0,
                                          13,   'I',  'H', 'D', 'R',  0,    0,    0x75, 0x30, 0, 0,
                                          0x75, 0x30, 8,   2,   0,    0,    0,    0,    0,    0, 0};
  std::ofstream(folder_ / "bomb.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), png.size());
  EXPECT_THAT(refusal(), HasSubstr("30000x30000 pixels cannot be used"));
  EXPECT_THAT(refusal(), HasSubstr("scale all pictures down"));
}

TEST_F(PictureFolders, DamagedPicturesAreNamed) {
  jpeg("a.jpg", 64, 48, 6);
  std::ifstream whole(folder_ / "a.jpg", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  for (std::size_t length = 0; length < bytes.size(); length += 5) {
    std::ofstream(folder_ / "a.jpg", std::ios::binary) << bytes.substr(0, length);
    (void)open_picture_folder(folder_ / "");  // must not crash
  }
  png("a.jpg.png", 64, 48);
  std::filesystem::remove(folder_ / "a.jpg");
  const auto folder = open_picture_folder(folder_ / "");
  ASSERT_TRUE(folder);
  std::filesystem::resize_file(folder_ / "a.jpg.png", 40);
  EXPECT_THAT(load_picture(*folder, folder->files[0]).error().what,
              HasSubstr("a.jpg.png: the picture is damaged"));
}

}  // namespace
}  // namespace copresence::calibrate
