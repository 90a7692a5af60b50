#include "render_client/display/screenshot.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

namespace copresence::display {
namespace {

TEST(Screenshot, EveryPixelIsInTheFileAndOpaque) {
  Image<Rgba8> view(37, 23);
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 37; ++x) {
      view(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y),
                    static_cast<std::uint8_t>(x * y), static_cast<std::uint8_t>(x)};
    }
  }
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("screenshot_test-" + std::to_string(::getpid()) + ".png");
  ASSERT_TRUE(write_png(path.string(), view));
  const cv::Mat shown = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  std::filesystem::remove(path);
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

TEST(Screenshot, APlaceThatCannotBeWrittenIsNamed) {
  const auto written = write_png("/no/such/folder/view.png", Image<Rgba8>(4, 4));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/no/such/folder/view.png"), std::string::npos) << written.error().what;
}

}  // namespace
}  // namespace copresence::display
