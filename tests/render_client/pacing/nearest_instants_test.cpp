#include "render_client/pacing/nearest_instants.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace copresence::pacing {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Duration kPeriod = microseconds(33'333);

Instant at_ms(double ms) {
  return Instant(microseconds(static_cast<std::int64_t>(std::lround(ms * 1000)) + 1'000'000));
}
double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

CameraOffer offer(std::vector<double> captured_ms, bool first_is_on_view, double fresh_since_ms = 0) {
  CameraOffer offer;
  for (const double instant : captured_ms) offer.captured.push_back(at_ms(instant));
  offer.first_is_on_view = first_is_on_view;
  offer.fresh_since = at_ms(fresh_since_ms);
  return offer;
}

TEST(NearestInstants, ShowsFramesOfOneInstantAtOnce) {
  const CameraOffer cameras[] = {offer({0, 33.3}, true, 40), offer({1, 34.3}, true, 41)};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(41));
  EXPECT_TRUE(choice.is_new);
  EXPECT_EQ(choice.frames[0], 1u);
  EXPECT_EQ(choice.frames[1], 1u);
  EXPECT_NEAR(ms(choice.skew), 1, 0.01);
}

TEST(NearestInstants, WaitsForANearerFrameThatIsUnderWay) {
  // The other camera's frame at 13 ms is 20 ms away. Its next one at 46 ms would be 13 ms away.
  const CameraOffer cameras[] = {offer({0, 33.3}, true, 40), offer({13}, true)};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(41));
  EXPECT_FALSE(choice.is_new);
  ASSERT_TRUE(choice.at_latest);
  EXPECT_EQ(*choice.at_latest, at_ms(40) + kPeriod / 2);
  const CameraOffer later[] = {offer({0, 33.3}, true, 40), offer({13, 46.3}, true, 53)};
  const FrameChoice then = nearest_instants(later, kPeriod, at_ms(53));
  EXPECT_TRUE(then.is_new);
  EXPECT_NEAR(ms(then.skew), 13, 0.01);
}

TEST(NearestInstants, WaitsForHalfAPeriodAtMost) {
  const CameraOffer cameras[] = {offer({0, 33.3}, true, 40), offer({13}, true)};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(57));
  EXPECT_TRUE(choice.is_new);
  EXPECT_EQ(choice.frames[0], 1u);
  EXPECT_EQ(choice.frames[1], 0u);
}

TEST(NearestInstants, ACameraThatStoppedHoldsUpNobody) {
  CameraOffer stopped = offer({-500}, true);
  stopped.delivers = false;
  const CameraOffer cameras[] = {offer({0, 33.3}, true, 40), stopped};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(41));
  EXPECT_TRUE(choice.is_new);
  EXPECT_EQ(choice.frames[1], 0u);
  EXPECT_EQ(choice.skew, Duration::zero());
}

TEST(NearestInstants, ACameraWithoutAFrameYetIsNotWaitedFor) {
  const CameraOffer cameras[] = {offer({33.3}, false, 40), CameraOffer{}};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(41));
  EXPECT_TRUE(choice.is_new);
  EXPECT_EQ(choice.frames[0], 0u);
  EXPECT_FALSE(choice.frames[1]);
}

TEST(NearestInstants, NothingNewIsNothingToShow) {
  const CameraOffer cameras[] = {offer({0}, true), offer({10}, true)};
  const FrameChoice choice = nearest_instants(cameras, kPeriod, at_ms(20));
  EXPECT_FALSE(choice.is_new);
  EXPECT_FALSE(choice.at_latest);
}

/// Free-running cameras, and a client that shows their frames by the rule.
class Playing {
 public:
  Playing(std::vector<double> phases_ms, double jitter_ms)
      : phases_(std::move(phases_ms)),
        jitter_(jitter_ms),
        offers_(phases_.size()),
        next_(phases_.size(), 0) {}

  void run(double until_ms) {
    for (; now_ < until_ms; now_ += 0.25) {
      for (std::size_t i = 0; i < phases_.size(); ++i) {
        const double captured = phases_[i] + next_[i] * 33.333;
        if (now_ < captured + delay_) continue;
        if (!offers_[i].has_fresh()) offers_[i].fresh_since = at_ms(now_);
        offers_[i].captured.push_back(at_ms(captured + std::normal_distribution<>(0, jitter_)(random_)));
        std::sort(offers_[i].captured.begin(), offers_[i].captured.end());
        ++next_[i];
      }
      show();
    }
  }

  int views = 0;
  double worst_skew_ms = 0, worst_wait_ms = 0;

 private:
  void show() {
    const FrameChoice choice = nearest_instants(offers_, kPeriod, at_ms(now_));
    for (const CameraOffer& camera : offers_) {
      if (camera.captured.empty()) return;
    }
    if (!choice.is_new) return;
    ++views;
    if (views > 3) worst_skew_ms = std::max(worst_skew_ms, ms(choice.skew));
    for (std::size_t i = 0; i < offers_.size(); ++i) {
      CameraOffer& camera = offers_[i];
      const auto chosen = static_cast<std::ptrdiff_t>(*choice.frames[i]);
      if (camera.has_fresh() && (chosen > 0 || !camera.first_is_on_view) && views > 3) {
        worst_wait_ms = std::max(worst_wait_ms, ms(at_ms(now_) - camera.fresh_since));
      }
      if (chosen > 0) camera.fresh_since = at_ms(now_);
      camera.captured.erase(camera.captured.begin(), camera.captured.begin() + chosen);
      camera.first_is_on_view = true;
    }
  }

  std::vector<double> phases_;
  double jitter_, delay_ = 20, now_ = 0;
  std::vector<CameraOffer> offers_;
  std::vector<int> next_;
  std::minstd_rand random_{7};
};

TEST(NearestInstants, TwoFreeRunningCamerasAreNeverFartherApartThanHalfAPeriod) {
  for (double phase = 0; phase < 33.3; phase += 1.7) {
    Playing playing({0, phase}, 0);
    playing.run(3000);
    EXPECT_LT(playing.worst_skew_ms, 17) << phase;
    EXPECT_LE(playing.worst_wait_ms, 17) << phase;
    EXPECT_GE(playing.views, 85) << phase;
  }
}

TEST(NearestInstants, FourFreeRunningCamerasSpanLessThanAPeriod) {
  for (const std::vector<double>& phases :
       {std::vector<double>{0, 8.3, 16.7, 25}, {0, 1, 2, 20}, {0, 11, 12, 30}, {0, 16, 17, 18}}) {
    Playing playing(phases, 0);
    playing.run(3000);
    EXPECT_LT(playing.worst_skew_ms, 25.5);
    EXPECT_LE(playing.worst_wait_ms, 17);
    EXPECT_GE(playing.views, 85);
  }
}

TEST(NearestInstants, JitterDelaysNothingForLong) {
  Playing playing({0, 16.5}, 1.5);
  playing.run(6000);
  EXPECT_LT(playing.worst_skew_ms, 23);
  EXPECT_LE(playing.worst_wait_ms, 17);
  EXPECT_GE(playing.views, 170);
}

}  // namespace
}  // namespace copresence::pacing
