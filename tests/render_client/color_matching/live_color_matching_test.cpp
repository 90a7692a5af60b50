#include "render_client/color_matching/live_color_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

namespace copresence::color_matching {
namespace {

using FirstMatch = LiveColorMatching::FirstMatch;
using std::chrono::milliseconds;

/// A camera at `x_m` in front of a colourful wall at 2.5 m. `gain` is the gain of its red channel.
std::shared_ptr<const client::CameraFrame> wall_seen_from(double x_m, double gain) {
  auto received = std::make_shared<client::CameraFrame>();
  client::CameraSetup setup;
  setup.model = {320, 240, 290, 290, 160, 120, {}};
  setup.has_pose = true;
  setup.fixed_pose.emplace().translation.x() = x_m;
  RgbdFrame& frame = received->frame;
  frame.depth = DepthImage(320, 240, std::uint16_t{2500});
  frame.state = StateImage(320, 240, DepthState::kMeasured);
  frame.color.emplace(320, 240);
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::clamp(255 * v, 0.0, 255.0)); };
  const auto wave = [](double v) { return 0.45 + 0.25 * std::sin(v); };
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const Eigen::Vector3d at = unproject(setup.model, {double(u), double(v)}, 2.5);
      const double x = at.x() + x_m, y = at.y();
      (*frame.color)(u, v) = {byte(gain * wave(3 * x + y)), byte(wave(2 * y - x + 1)),
                              byte(wave(2.5 * x - 2 * y + 2))};
    }
  }
  received->setup = std::make_shared<const client::CameraSetup>(setup);
  return received;
}

bool is_awaited_for(const LiveColorMatching& matching, std::span<const std::size_t> cameras) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (matching.first_match(cameras) == FirstMatch::kAwaited) {
    if (std::chrono::steady_clock::now() > limit) return true;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return false;
}

constexpr std::size_t kBoth[] = {0, 1};

TEST(LiveColorMatching, FindsTheFirstMatchOfCamerasThatOverlap) {
  LiveColorMatching matching(2);
  EXPECT_EQ(matching.first_match(kBoth), FirstMatch::kAwaited);
  matching.show(0, wall_seen_from(0, 1));
  matching.show(1, wall_seen_from(0.4, 0.8));
  const std::jthread thread([&](const std::stop_token& stop) { matching.run(stop); });
  ASSERT_FALSE(is_awaited_for(matching, kBoth));
  EXPECT_EQ(matching.first_match(kBoth), FirstMatch::kFound);
  EXPECT_TRUE(matching.is_matched(1));
  EXPECT_NEAR(matching.correction(1)(0, 0), 1 / 0.8, 0.1);
  matching.forget(1);
  EXPECT_NEAR(matching.correction(1)(0, 0), 1 / 0.8, 0.1) << "a camera that is stale keeps its correction";
}

TEST(LiveColorMatching, GivesUpOnCamerasThatSeeNothingInCommon) {
  LiveColorMatching matching(2);
  matching.show(0, wall_seen_from(0, 1));
  matching.show(1, wall_seen_from(40, 0.8));
  const std::jthread thread([&](const std::stop_token& stop) { matching.run(stop); });
  ASSERT_FALSE(is_awaited_for(matching, kBoth));
  EXPECT_EQ(matching.first_match(kBoth), FirstMatch::kGivenUp);
  EXPECT_FALSE(matching.is_matched(1));
}

}  // namespace
}  // namespace copresence::color_matching
