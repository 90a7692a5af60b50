// How well the fillers guess, against the simulator's truth: holes at most 30 pixels wide whose true depth is in range.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "capture_server/hole_filling/hole_filler.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::hole_filling {
namespace {

constexpr int kWidest = 30;
constexpr float kStepsMm = 351300;

struct Shot {
  RgbdFrame frame;
  Image<float> truth_m;
};

std::vector<Shot> shots_of_the_room() {
  auto world = std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
  const auto poses = simulation::kinect_poses(2);
  std::vector<Shot> shots;
  for (std::size_t camera = 0; camera < poses.size(); ++camera) {
    auto kinect = simulation::SimulatedKinect::make(world, simulation::kinect_model(640, 480), poses, camera,
                                                    DepthUnit::kMillimetre, 1)
                      .value();
    Shot shot;
    ColorImage color;
    kinect.capture(0.4, 24, shot.frame.depth, color);
    shot.frame.color = std::move(color);
    shot.frame.state = StateImage(640, 480, DepthState::kMeasured);
    for (std::size_t i = 0; i < shot.frame.depth.pixels().size(); ++i) {
      if (shot.frame.depth.pixels()[i] == 0) shot.frame.state.pixels()[i] = DepthState::kHole;
    }
    shot.truth_m = kinect.truth().depth_m;
    shots.push_back(std::move(shot));
  }
  return shots;
}

/// Whether a filled depth lies between the true surfaces around a pixel and on none of them, to four steps.
bool hangs_between(const Image<float>& truth_m, int x, int y, float steps) {
  float farthest = 1e9f, nearest = 0, closest = 1e9f;
  for (int v = std::max(0, y - 4); v <= std::min(479, y + 4); ++v) {
    for (int u = std::max(0, x - 4); u <= std::min(639, x + 4); ++u) {
      if (truth_m(u, v) <= 0) continue;
      const float s = kStepsMm / 1000 / truth_m(u, v);
      farthest = std::min(farthest, s);
      nearest = std::max(nearest, s);
      closest = std::min(closest, std::abs(s - steps));
    }
  }
  return closest > 4 && steps > farthest && steps < nearest;
}

struct Quality {
  double filled_percent, median_steps, p90_steps, between_percent;
};

Quality judge(Method method, std::vector<Shot> shots, bool color) {
  auto filler = open(method, Compute::kCpu, {}).value();
  std::vector<float> errors;
  int narrow = 0, between = 0;
  for (Shot& shot : shots) {
    const StateImage before = shot.frame.state;
    if (!color) shot.frame.color.reset();
    EXPECT_TRUE(filler->fill(shot.frame));
    for (int y = 0; y < 480; ++y) {
      for (int x = 0, end = 0; x < 640; x = std::max(x + 1, end)) {
        for (end = x; end < 640 && before(end, y) == DepthState::kHole;) ++end;
        if (end - x > kWidest) continue;
        for (int u = x; u < end; ++u) {
          const float truth = shot.truth_m(u, y);
          if (truth < 0.4f || truth > 5) continue;
          ++narrow;
          if (shot.frame.state(u, y) != DepthState::kFilled) continue;
          const float steps = kStepsMm / shot.frame.depth(u, y);
          errors.push_back(std::abs(steps - kStepsMm / 1000 / truth));
          between += hangs_between(shot.truth_m, u, y, steps);
        }
      }
    }
  }
  std::sort(errors.begin(), errors.end());
  const double filled = static_cast<double>(errors.size());
  return {100 * filled / narrow, errors[errors.size() / 2], errors[errors.size() * 9 / 10],
          100 * between / filled};
}

TEST(HoleFillingOnTheSimulator, JointComesNearTheTruth) {
  const std::vector<Shot> shots = shots_of_the_room();
  for (const Method method : {Method::kJoint, Method::kBilateral, Method::kMedian}) {
    for (const bool color : {true, false}) {
      const Quality quality = judge(method, shots, color);
      std::printf(
          "%-9s %-9s filled %5.1f %%, median error %.2f steps, 90th percentile %.2f, between surfaces %.2f "
          "%%\n",
          std::string(name(method)).c_str(), color ? "color" : "colorless", quality.filled_percent,
          quality.median_steps, quality.p90_steps, quality.between_percent);
      if (method != Method::kJoint) continue;
      EXPECT_GE(quality.filled_percent, 95);
      EXPECT_LT(quality.median_steps, 3);
      EXPECT_LT(quality.between_percent, 1);
    }
  }
}

}  // namespace
}  // namespace copresence::hole_filling
