// Draws a picture that compares the hole fillers, as in thesis figures 3.4 and 3.5. Usage:
// filler_pictures OUT.jpg
//
// It shows colour, measured depth, true depth and each filler's depth in the simulated room.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "capture_server/hole_filling/hole_filler.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::hole_filling {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Draws depth: near is red, far is blue, and a hole is black. The scale is linear in 1 / depth.
cv::Mat picture_of(const DepthImage& depth_mm) {
  constexpr double kNear = 1 / 900.0, kFar = 1 / 5000.0;
  cv::Mat gray(kHeight, kWidth, CV_8UC1), colored;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double nearness = (1.0 / std::max<int>(depth_mm(x, y), 1) - kFar) / (kNear - kFar);
      gray.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255 * std::min(nearness, 1.0));
    }
  }
  cv::applyColorMap(gray, colored, cv::COLORMAP_TURBO);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (depth_mm(x, y) == 0) colored.at<cv::Vec3b>(y, x) = {0, 0, 0};
    }
  }
  return colored;
}

cv::Mat picture_of(const ColorImage& color) {
  cv::Mat picture(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Rgb8 pixel = color(x, y);
      picture.at<cv::Vec3b>(y, x) = {pixel.b, pixel.g, pixel.r};
    }
  }
  return picture;
}

cv::Mat titled(cv::Mat picture, std::string_view title) {
  cv::rectangle(picture, {0, 0, 14 + 13 * static_cast<int>(title.size()), 34}, {255, 255, 255}, cv::FILLED);
  cv::putText(picture, std::string(title), {8, 25}, cv::FONT_HERSHEY_SIMPLEX, 0.7, {0, 0, 0}, 2, cv::LINE_AA);
  return picture;
}

int draw(const char* path) {
  auto world = std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
  auto kinect = simulation::SimulatedKinect::make(world, simulation::kinect_model(kWidth, kHeight),
                                                  simulation::kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
                    .value();
  RgbdFrame measured;
  ColorImage color;
  kinect.capture(0.4, 24, measured.depth, color);
  measured.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  DepthImage truth(kWidth, kHeight);
  for (std::size_t i = 0; i < measured.depth.pixels().size(); ++i) {
    if (measured.depth.data()[i] == 0) measured.state.data()[i] = DepthState::kHole;
    truth.data()[i] = static_cast<std::uint16_t>(std::lround(1000 * kinect.truth().depth_m.data()[i]));
  }
  cv::Mat above, below;
  cv::hconcat(
      std::vector<cv::Mat>{titled(picture_of(color), "colour"),
                           titled(picture_of(measured.depth), "measured"), titled(picture_of(truth), "true")},
      above);
  measured.color = std::move(color);
  std::vector<cv::Mat> filled;
  for (const Method method : {Method::kMedian, Method::kBilateral, Method::kJoint}) {
    RgbdFrame frame = measured;
    if (!open(method, Compute::kCpu, {}).value()->fill(frame)) return 1;
    filled.push_back(titled(picture_of(frame.depth), name(method)));
  }
  cv::hconcat(filled, below);
  cv::Mat all;
  cv::vconcat(above, below, all);
  cv::resize(all, all, {}, 0.75, 0.75, cv::INTER_AREA);
  if (cv::imwrite(path, all, {cv::IMWRITE_JPEG_QUALITY, 88})) return 0;
  fmt::print(stderr, "filler_pictures: {} cannot be written; give a path that ends in .jpg\n", path);
  return 1;
}

}  // namespace
}  // namespace copresence::hole_filling

int main(int argc, char** argv) {
  if (argc == 2) return copresence::hole_filling::draw(argv[1]);
  fmt::print(stderr, "usage: filler_pictures OUT.jpg\n");
  return 2;
}
