// Draws the picture in docs/internals/simulation.md. Usage: kinect_picture OUT.jpg
//
// The picture shows the colours of camera 1 in the simulated room, and its depth with holes in red.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "simulation/sensor/simulated_kinect.h"

namespace copresence::simulation {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Draws depth: near is white and far is black. Grey values are linear in 1 / depth.
cv::Mat picture_of(const DepthImage& depth_mm) {
  constexpr double kNear = 1 / 1200.0, kFar = 1 / 5500.0;
  cv::Mat picture(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto depth = depth_mm(x, y);
      const double nearness = (1.0 / std::max<int>(depth, 1) - kFar) / (kNear - kFar);
      const auto gray = cv::saturate_cast<std::uint8_t>(255 * nearness);
      picture.at<cv::Vec3b>(y, x) = depth ? cv::Vec3b(gray, gray, gray) : cv::Vec3b(0, 0, 190);
    }
  }
  return picture;
}

int draw(const char* path) {
  const auto world = std::make_shared<const LitScene>(LitScene::of_world("room").value());
  auto kinect = SimulatedKinect::make(world, kinect_model(kWidth, kHeight), kinect_poses(2), 1,
                                      DepthUnit::kMillimetre, 1)
                    .value();
  DepthImage depth;
  ColorImage color;
  kinect.capture(0.25, 15, depth, color);
  const cv::Mat rgb(kHeight, kWidth, CV_8UC3, color.data());
  cv::Mat bgr, both;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::hconcat(bgr, picture_of(depth), both);
  if (cv::imwrite(path, both, {cv::IMWRITE_JPEG_QUALITY, 80})) return 0;
  fmt::print(stderr, "kinect_picture: {} cannot be written; give a path that ends in .jpg\n", path);
  return 1;
}

}  // namespace
}  // namespace copresence::simulation

int main(int argc, char** argv) {
  if (argc == 2) return copresence::simulation::draw(argv[1]);
  fmt::print(stderr, "usage: kinect_picture OUT.jpg\n");
  return 2;
}
