// Compares the client's view of the simulated room, from between its cameras, with the picture of a
// perfect camera. This measures the errors of sensors, hole filling, meshing, merging and colour
// matching. Frames are not coded. The test fidelity_test.cpp measures the errors of coding.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/color/yuv420.h"
#include "common/flow/worker_pool.h"
#include "render_client/color_matching/color_matcher.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/viewpoint/look_at.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::testing {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr double kPhase = 0.15;
constexpr double kCalibrationErrorM = 0.005;
constexpr std::uint64_t kHalfASecond = 15;  // In frames.

cv::Mat to_mat(const Image<Rgba8>& image) {
  cv::Mat rgb(image.height(), image.width(), CV_8UC3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Rgba8 p = image(x, y);
      rgb.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
    }
  }
  return rgb;
}

cv::Mat to_mat(const ColorImage& image) {
  cv::Mat rgb(image.height(), image.width(), CV_8UC3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Rgb8 p = image(x, y);
      rgb.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
    }
  }
  return rgb;
}

class MergedTruth : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
    poses_ = simulation::kinect_poses(2);
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      kinects_.push_back(simulation::SimulatedKinect::make(world_, simulation::kinect_model(640, 480), poses_,
                                                           i, DepthUnit::kMillimetre, 7)
                             .value());
    }
    const Eigen::Vector3d middle = 0.5 * (poses_[0].translation + poses_[1].translation);
    const Eigen::Vector3d target =
        0.5 * (poses_[0] * Eigen::Vector3d(0, 0, 2.4) + poses_[1] * Eigen::Vector3d(0, 0, 2.4));
    eye_.intrinsics = camera_from_field_of_view(kWidth, kHeight, 50 * std::numbers::pi / 180);
    // Not on the line between the cameras, where a wardrobe stands.
    eye_.world_from_eye = viewpoint::look_at(middle + 0.2 * (target - middle), target, {0, -1, 0});
  }
  static void TearDownTestSuite() {
    kinects_.clear();
    world_.reset();
  }

  /// Returns the client's frames of all cameras at one instant of the still scene. Holes are
  /// filled, and noise is filtered over time.
  std::vector<RgbdFrame> frames(std::uint64_t number) {
    std::vector<RgbdFrame> result;
    for (std::size_t i = 0; i < kinects_.size(); ++i) {
      simulation::SimulatedKinect& kinect = kinects_[i];
      RgbdFrame frame;
      kinect.capture(kPhase, number, frame.depth, frame.color.emplace());
      frame.state = StateImage(640, 480, DepthState::kMeasured);
      server::clip_to_range(frame, to_units(DepthRange{}, DepthUnit::kMillimetre));
      const auto filler = hole_filling::open(hole_filling::Method::kJoint, hole_filling::Compute::kCpu,
                                             {640, 480, DepthUnit::kMillimetre, DepthRange{}});
      EXPECT_TRUE((*filler)->fill(frame));
      depth_filters_[i].apply(frame.depth, frame.state);
      Picture coded;
      color::rgb_to_yuv420(*frame.color, coded);
      color_filters_[i].apply(coded, false);
      color::yuv420_to_rgb(coded, *frame.color);
      decoding::DepthSmoothing().smooth(frame.depth, DepthUnit::kMillimetre, kKinectV1Noise);
      result.push_back(std::move(frame));
    }
    return result;
  }

  /// As a viewer who has looked for half a second has them.
  std::vector<RgbdFrame> frames_after_half_a_second() {
    for (std::uint64_t number = 1; number < kHalfASecond; ++number) frames(number);
    return frames(kHalfASecond);
  }

  static std::vector<std::optional<color_matching::ColorCorrection>> match(
      const std::vector<RgbdFrame>& frames) {
    std::vector<color_matching::PosedFrame> posed;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      posed.push_back({&frames[i], kinects_[i].model(), DepthUnit::kMillimetre, kKinectV1Noise, poses_[i],
                       kCalibrationErrorM});
    }
    return color_matching::match_colors(posed);
  }

  static renderer::MergedView show(const std::vector<RgbdFrame>& frames,
                                   const std::vector<std::optional<color_matching::ColorCorrection>>& maps) {
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      renderer::CameraView view;
      view.frame = &frames[i];
      view.version = 1;
      view.model = kinects_[i].model();
      view.world_from_camera = poses_[i];
      view.calibration_error_m = kCalibrationErrorM;
      if (maps[i]) view.color_correction = *maps[i];
      views.push_back(view);
    }
    flow::WorkerPool workers(2, "view");
    renderer::MergedView merged;
    EXPECT_TRUE(
        renderer::make_cpu_renderer(workers)->render(views, eye_, {.color = true, .depth = true}, merged));
    return merged;
  }

  static simulation::TrueCamera true_camera(const CameraModel& model, const Rigid3& pose) {
    return simulation::TrueCamera::make(world_, model, pose).value();
  }

  /// Returns the PSNR over squares of `side` pixels a side. The colour of a square is the mean of
  /// its shown pixels, which must be at least half of the pixels. With side = 1, every error
  /// counts. Larger squares ignore small shifts of texture.
  static double psnr_of_shown(const renderer::MergedView& view, const ColorImage& truth, int side) {
    double squares = 0;
    int areas = 0;
    for (int top = 0; top + side <= kHeight; top += side) {
      for (int left = 0; left + side <= kWidth; left += side) {
        Eigen::Vector3d difference = Eigen::Vector3d::Zero();
        int shown = 0;
        for (int y = top; y < top + side; ++y) {
          for (int x = left; x < left + side; ++x) {
            if (view.camera(x, y) == renderer::kNoCamera) continue;
            const Rgba8 a = view.color(x, y);
            const Rgb8 b = truth(x, y);
            difference += Eigen::Vector3d(a.r - b.r, a.g - b.g, a.b - b.b);
            ++shown;
          }
        }
        if (2 * shown < side * side) continue;
        squares += (difference / shown).squaredNorm();
        ++areas;
      }
    }
    return 10 * std::log10(255.0 * 255.0 * 3 * areas / squares);
  }

  static temporal_filter::DepthFilter depth_filter() {
    return {640, 480, DepthUnit::kMillimetre, kKinectV1Noise};
  }

  std::array<temporal_filter::DepthFilter, 2> depth_filters_{depth_filter(), depth_filter()};
  std::array<temporal_filter::ColorFilter, 2> color_filters_;
  static inline std::shared_ptr<const simulation::LitScene> world_;
  static inline std::vector<Rigid3> poses_;
  static inline std::vector<simulation::SimulatedKinect> kinects_;
  static inline viewpoint::ViewPose eye_;
};

TEST_F(MergedTruth, ColourMatchingBringsTheViewNearTheTruth) {
  const auto captured = frames_after_half_a_second();
  const auto maps = match(captured);
  ASSERT_TRUE(maps[1]);
  const std::vector<std::optional<color_matching::ColorCorrection>> none(2);
  const auto matched = show(captured, maps), unmatched = show(captured, none);
  auto eye = true_camera(eye_.intrinsics, eye_.world_from_eye);
  const ColorImage& truth = eye.trace(kPhase).color;
  const double with = psnr_of_shown(matched, truth, 1), without = psnr_of_shown(unmatched, truth, 1);
  const double areas_with = psnr_of_shown(matched, truth, 16),
               areas_without = psnr_of_shown(unmatched, truth, 16);
  std::cout << fmt::format(
      "PSNR {:.1f} dB with colour matching, {:.1f} dB without; of areas {:.1f} and {:.1f} dB\n", with,
      without, areas_with, areas_without);
  if (const char* folder = std::getenv("COPRESENCE_KEEP_PICTURES")) {
    cv::imwrite(std::string(folder) + "/matched.png", to_mat(matched.color));
    cv::imwrite(std::string(folder) + "/unmatched.png", to_mat(unmatched.color));
    cv::imwrite(std::string(folder) + "/truth.png", to_mat(truth));
  }
  EXPECT_GE(with, 25.5);
  EXPECT_GE(with, without + 4.0);
}

TEST_F(MergedTruth, AStillSceneStandsStill) {
  auto captured = frames_after_half_a_second();
  const auto maps = match(captured);
  auto before = show(captured, maps);
  double change = 0;
  int pixels = 0;
  for (std::uint64_t number = kHalfASecond + 1; number <= kHalfASecond + 5; ++number) {
    const auto view = show(frames(number), maps);
    for (std::size_t i = 0; i < view.color.pixels().size(); ++i) {
      if (view.camera.data()[i] == renderer::kNoCamera && before.camera.data()[i] == renderer::kNoCamera)
        continue;
      const Rgba8 a = view.color.data()[i], b = before.color.data()[i];
      change += (std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b)) / 3.0;
      ++pixels;
    }
    before = view;
  }
  std::cout << fmt::format("a still scene changes by {:.2f} of 255 from frame to frame\n", change / pixels);
  EXPECT_LT(change / pixels, 1.5);
}

TEST_F(MergedTruth, ShowsWhatACameraSees) {
  const auto captured = frames_after_half_a_second();
  const auto view = show(captured, match(captured));
  auto eye = true_camera(eye_.intrinsics, eye_.world_from_eye);
  const Image<float> truth = eye.trace(kPhase).depth_m;
  std::vector<Image<float>> seen;
  for (const auto& kinect : kinects_) {
    auto camera = true_camera(kinect.model(), kinect.world_from_camera());
    seen.push_back(camera.trace(kPhase).depth_m);
  }
  int should = 0, missing = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (truth(x, y) <= 0) continue;
      const Eigen::Vector3d point =
          eye_.world_from_eye * unproject(eye_.intrinsics, {double(x), double(y)}, truth(x, y));
      bool in_sight = false;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const Eigen::Vector3d there = poses_[i].inverse() * point;
        if (there.z() < 0.4 || there.z() > 5) continue;
        const Eigen::Vector2d pixel = project(kinects_[i].model(), there);
        const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
        if (u < 0 || v < 0 || u >= 640 || v >= 480) continue;
        in_sight = in_sight || std::abs(seen[i](u, v) - there.z()) < 0.03;
      }
      should += in_sight;
      missing += in_sight && view.camera(x, y) == renderer::kNoCamera;
    }
  }
  const double percent = 100.0 * missing / should;
  std::cout << fmt::format("{:.2f} % of {} pixels that should show something do not\n", percent, should);
  EXPECT_LT(percent, 3.0);
}

}  // namespace
}  // namespace copresence::testing
