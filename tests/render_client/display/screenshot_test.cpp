#include "render_client/display/screenshot.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

namespace copresence::display {
namespace {

Image<Rgba8> colorful(int width, int height) {
  Image<Rgba8> view(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      view(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y),
                    static_cast<std::uint8_t>(x * y), 255};
    }
  }
  return view;
}

cv::Mat written_and_read(const Image<Rgba8>& view) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("screenshot_test-" + std::to_string(::getpid()) + ".png");
  EXPECT_TRUE(write_png(path.string(), view));
  cv::Mat image = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  std::filesystem::remove(path);
  return image;
}

TEST(Screenshot, HasNoAlphaIfEveryPixelIsOpaque) {
  const Image<Rgba8> view = colorful(37, 23);
  const cv::Mat shown = written_and_read(view);
  ASSERT_EQ(shown.type(), CV_8UC3);
  ASSERT_EQ(shown.cols, 37);
  ASSERT_EQ(shown.rows, 23);
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 37; ++x) {
      const Rgba8& pixel = view(x, y);
      EXPECT_EQ(shown.at<cv::Vec3b>(y, x), cv::Vec3b(pixel.b, pixel.g, pixel.r)) << x << ", " << y;
    }
  }
}

TEST(Screenshot, HasTheAlphaOfPixelsThatShowNothing) {
  Image<Rgba8> view = colorful(37, 23);
  view(5, 7).a = 0;
  const cv::Mat shown = written_and_read(view);
  ASSERT_EQ(shown.type(), CV_8UC4);
  EXPECT_EQ(shown.at<cv::Vec4b>(7, 5), cv::Vec4b(35, 77, 35, 0)) << "blue, green, red, alpha";
  EXPECT_EQ(shown.at<cv::Vec4b>(7, 6), cv::Vec4b(42, 77, 42, 255));
}

TEST(Screenshot, APlaceThatCannotBeWrittenIsNamed) {
  const auto written = write_png("/no/such/folder/view.png", Image<Rgba8>(4, 4));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/no/such/folder/view.png"), std::string::npos) << written.error().what;
}

}  // namespace
}  // namespace copresence::display
