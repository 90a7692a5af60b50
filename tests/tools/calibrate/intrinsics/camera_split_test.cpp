// Views of two cameras must be noticed, and views of one camera must not be taken for two. Random
// corners have the noise of a corner detector. The table in docs/guide/calibration.md has more sets
// of the same kind.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <ostream>
#include <random>
#include <string>

#include "tools/calibrate/intrinsics/intrinsics_fit.h"

namespace copresence::calibrate {
namespace {

const CameraModel kCamera{640, 480, 580, 583, 322, 236, {0.12, -0.2, 0.0012, -0.0009, 0, 0, 0, 0}};
const CameraModel kWide{640, 480, 275, 275, 320, 240, {-0.28, 0.06, 0, 0, 0, 0, 0, 0}};

struct Setting {
  double bend_m = 0;  ///< Distance of the board's edges in front of its centre.
  double nearest_m = 0.25, farthest_m = 0.8;
};

// A random view of a board of 9x6 corners, 25 mm apart. Each coordinate errs by 0.1 px, and the
// whole view by a smooth error of 0.05 px.
BoardView random_view(const CameraModel& camera, const Setting& setting, std::mt19937& random) {
  constexpr int kColumns = 9, kRows = 6;
  constexpr double kSquare = 0.025, kTilt = 0.7, kNoise = 0.1, kSmooth = 0.05;
  std::normal_distribution<double> noise;
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (;;) {
    const double pitch = between(-kTilt, kTilt), yaw = between(-kTilt, kTilt), roll = between(-0.5, 0.5);
    const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
                                         .toRotationMatrix();
    const double z = between(setting.nearest_m, setting.farthest_m);
    const double column = between(0, camera.width), row = between(0, camera.height);
    const Eigen::Vector3d middle(0.5 * kSquare * (kColumns - 1), 0.5 * kSquare * (kRows - 1), 0);
    const Eigen::Vector3d center((column - camera.cx) / camera.fx * z, (row - camera.cy) / camera.fy * z, z);
    const Rigid3 pose{rotation, center - rotation * middle};
    const double smooth_x = kSmooth * noise(random), smooth_y = kSmooth * noise(random);
    BoardView view;
    bool is_whole = true;
    for (int y = 0; y < kRows && is_whole; ++y) {
      for (int x = 0; x < kColumns && is_whole; ++x) {
        const double u = 2.0 * x / (kColumns - 1) - 1, v = 2.0 * y / (kRows - 1) - 1;
        const Eigen::Vector2d on_board(kSquare * x, kSquare * y);
        const Eigen::Vector3d p =
            pose * Eigen::Vector3d(on_board.x(), on_board.y(), setting.bend_m * (u * u + 0.5 * u * v));
        is_whole = p.z() > 0.05 && p.head<2>().norm() < 1.6 * p.z();
        if (!is_whole) break;
        const Eigen::Vector2d pixel = project(camera, p) +
                                      kNoise * Eigen::Vector2d(noise(random), noise(random)) +
                                      Eigen::Vector2d(smooth_x * u * v, smooth_y * (u * u - 0.3));
        is_whole =
            pixel.x() > 3 && pixel.y() > 3 && pixel.x() < camera.width - 4 && pixel.y() < camera.height - 4;
        view.on_board.push_back(on_board);
        view.pixels.push_back(pixel);
      }
    }
    if (is_whole) return view;
  }
}

enum class Order { kInterleaved, kHalves };

std::vector<BoardView> views_of(const CameraModel& first, const CameraModel& second, Order order, int count,
                                const Setting& setting, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const bool is_second = order == Order::kInterleaved ? i % 2 == 1 : 2 * i >= count;
    views.push_back(random_view(is_second ? second : first, setting, random));
    views.back().picture = (is_second ? "second " : "first ") + std::to_string(i);
  }
  return views;
}

bool says_two_cameras(const std::vector<BoardView>& views) {
  const auto fit = fit_intrinsics(views, 640, 480);
  return !fit && fit.error().what.find("they seem to be of two cameras") != std::string::npos;
}

struct Mixture {
  double ratio;  ///< Of the two focal lengths.
  int least;     ///< Required number of noticed sets, of 4.
};

std::ostream& operator<<(std::ostream& out, const Mixture& mixture) {
  return out << mixture.ratio;
}

class TwoCameras : public testing::TestWithParam<Mixture> {};

TEST_P(TwoCameras, AreNoticedByTheirFocalLengths) {
  CameraModel other = kCamera;
  other.fx /= GetParam().ratio;
  other.fy /= GetParam().ratio;
  int noticed = 0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    for (const Order order : {Order::kInterleaved, Order::kHalves}) {
      noticed += says_two_cameras(views_of(kCamera, other, order, 16, {}, seed));
    }
  }
  EXPECT_GE(noticed, GetParam().least);
}

INSTANTIATE_TEST_SUITE_P(Ratios, TwoCameras,
                         testing::Values(Mixture{1.05, 3}, Mixture{1.10, 4}, Mixture{1.16, 4},
                                         Mixture{1.30, 4}));

struct Honest {
  const char* name;
  CameraModel camera;
  int views;
  Setting setting;
};

std::ostream& operator<<(std::ostream& out, const Honest& honest) {
  return out << honest.name;
}

class OneCamera : public testing::TestWithParam<Honest> {};

TEST_P(OneCamera, IsNeverTakenForTwo) {
  for (unsigned seed = 11; seed <= 13; ++seed) {
    const Honest& honest = GetParam();
    EXPECT_FALSE(says_two_cameras(
        views_of(honest.camera, honest.camera, Order::kHalves, honest.views, honest.setting, seed)))
        << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, OneCamera,
                         testing::Values(Honest{"flat board", kCamera, 16, {}},
                                         Honest{"board bent by 0.5 mm", kCamera, 16, {0.0005, 0.25, 0.8}},
                                         Honest{"wide lens", kWide, 16, {0, 0.15, 0.5}},
                                         Honest{"few views", kCamera, 7, {0.0003, 0.25, 0.8}}),
                         [](const auto& set) {
                           std::string name = set.param.name;
                           std::erase_if(name,
                                         [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
                           return name;
                         });

}  // namespace
}  // namespace copresence::calibrate
