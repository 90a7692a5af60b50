#include "render_client/pacing/render_pacer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>
#include <vector>

namespace copresence::pacing {
namespace {

constexpr double kPeriodMs = 1000.0 / 30;

Instant at_ms(double ms) {
  return Instant(std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms)));
}
double ms(Instant instant) {
  return std::chrono::duration<double, std::milli>(instant.time_since_epoch()).count();
}

struct SimulatedCamera {
  double phase_ms = 0;
  double period_ms = kPeriodMs;
  double jitter_ms = 3;  ///< standard deviation
  double stops_at_ms = 1e9;
};

struct Outcome {
  double views_per_second = 0;
  std::vector<double> p95_wait_ms;  ///< for each camera, from a frame's arrival to the view that shows it
  std::vector<double> shown;        ///< for each camera, fraction of its frames that a view shows
  double worst_p95() const { return *std::max_element(p95_wait_ms.begin(), p95_wait_ms.end()); }
};

/// Simulates one minute of cameras, a pacer and a renderer that takes `render_ms`. The first two
/// seconds do not count.
Outcome run(const std::vector<SimulatedCamera>& cameras, double views_per_second = 30, double render_ms = 10,
            unsigned seed = 1) {
  constexpr double kEndMs = 60'000, kCountFromMs = 2'000;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  struct Arrival {
    double ms;
    int camera;
  };
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    double last = 0;
    for (int n = 1; n * cameras[i].period_ms < std::min(kEndMs, cameras[i].stops_at_ms); ++n) {
      last = std::max(last,
                      cameras[i].phase_ms + n * cameras[i].period_ms + cameras[i].jitter_ms * normal(random));
      arrivals.push_back({last, static_cast<int>(i)});
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.ms < b.ms; });

  RenderPacer pacer(static_cast<int>(cameras.size()), views_per_second);
  std::vector<std::optional<double>> waiting(cameras.size());
  std::vector<std::vector<double>> waits(cameras.size());
  std::vector<int> arrived(cameras.size());
  double now = 0, busy_until = 0;
  int views = 0;
  std::size_t next = 0;
  while (next < arrivals.size()) {
    const auto asked = pacer.next_render_at(at_ms(now));
    const double render_at = asked ? std::max({ms(*asked), now, busy_until}) : 1e18;
    if (arrivals[next].ms <= render_at) {
      now = std::max(now, arrivals[next].ms);
      const auto camera = static_cast<std::size_t>(arrivals[next].camera);
      pacer.frame_arrived(arrivals[next].camera, at_ms(now));
      waiting[camera] = now;
      if (now > kCountFromMs) ++arrived[camera];
      ++next;
      continue;
    }
    now = render_at;
    busy_until = now + render_ms;
    pacer.rendered(at_ms(now));
    if (now > kCountFromMs) ++views;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (waiting[i] && now > kCountFromMs) waits[i].push_back(now - *waiting[i]);
      waiting[i].reset();
    }
  }
  Outcome outcome;
  outcome.views_per_second = views / ((now - kCountFromMs) / 1000);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    outcome.shown.push_back(static_cast<double>(waits[i].size()) / std::max(arrived[i], 1));
    std::sort(waits[i].begin(), waits[i].end());
    outcome.p95_wait_ms.push_back(waits[i].empty() ? 0 : waits[i][waits[i].size() * 95 / 100]);
  }
  return outcome;
}

TEST(RenderPacer, HasNothingToRenderUntilAFrameCame) {
  RenderPacer pacer(2, 30);
  EXPECT_EQ(pacer.next_render_at(at_ms(5)), std::nullopt);
  pacer.frame_arrived(1, at_ms(6));
  EXPECT_LE(pacer.next_render_at(at_ms(6)), at_ms(6));
  pacer.rendered(at_ms(6));
  EXPECT_EQ(pacer.next_render_at(at_ms(7)), std::nullopt);
}

TEST(RenderPacer, RendersASingleCamerasFramesAsTheyCome) {
  const Outcome outcome = run({{.phase_ms = 7}});
  EXPECT_GE(outcome.views_per_second, 29.5);
  EXPECT_LE(outcome.p95_wait_ms[0], 2);
  EXPECT_GE(outcome.shown[0], 0.99);
}

TEST(RenderPacer, NeverRendersMoreOftenThanAllowed) {
  EXPECT_LE(run({{.period_ms = 10, .jitter_ms = 1}}).views_per_second, 30 * 1.01 + 0.1);
  EXPECT_LE(run({{.phase_ms = 0}, {.phase_ms = 8}, {.phase_ms = 17}, {.phase_ms = 25}}).views_per_second,
            30.4);
}

TEST(RenderPacer, LetsNoFrameOfTwoCamerasWaitLongerThanHalfAPeriodAndJitter) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    const double phase = kPeriodMs * seed / 24;
    const Outcome outcome = run({{.phase_ms = 5}, {.phase_ms = 5 + phase}}, 30, 10, seed);
    EXPECT_GE(outcome.views_per_second, 29.5) << phase;
    EXPECT_LE(outcome.worst_p95(), kPeriodMs / 2 + 8) << phase;
  }
}

TEST(RenderPacer, ShowsTwoCamerasInStepTogether) {
  const Outcome outcome = run({{.phase_ms = 5}, {.phase_ms = 6}});
  EXPECT_GE(outcome.views_per_second, 29.5);
  EXPECT_LE(outcome.worst_p95(), 12);
  EXPECT_GE(outcome.shown[0], 0.98);
  EXPECT_GE(outcome.shown[1], 0.98);
}

TEST(RenderPacer, KeepsFourCamerasOfAnyPhaseBelowAPeriodLessTheLongestGap) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any_phase(0, kPeriodMs);
  for (unsigned seed = 0; seed < 24; ++seed) {
    std::vector<SimulatedCamera> cameras(4);
    std::vector<double> phases;
    for (auto& camera : cameras) phases.push_back(camera.phase_ms = any_phase(random));
    std::sort(phases.begin(), phases.end());
    double longest_gap = phases[0] + kPeriodMs - phases[3];
    for (int i = 0; i < 3; ++i) longest_gap = std::max(longest_gap, phases[i + 1] - phases[i]);
    const Outcome outcome = run(cameras, 30, 10, seed);
    EXPECT_GE(outcome.views_per_second, 29.5);
    EXPECT_LE(outcome.worst_p95(), kPeriodMs - longest_gap + 11) << "gap " << longest_gap;
  }
}

TEST(RenderPacer, FollowsCamerasWhoseClocksDriftApart) {
  const Outcome outcome = run({{.phase_ms = 0}, {.phase_ms = 3, .period_ms = 1000 / 29.97}});
  EXPECT_GE(outcome.views_per_second, 29.5);
  EXPECT_LE(outcome.worst_p95(), kPeriodMs / 2 + 9);
}

TEST(RenderPacer, KeepsUpWithACameraALittleFasterThanAllowed) {
  const Outcome outcome = run({{.phase_ms = 0, .period_ms = 1000 / 30.1, .jitter_ms = 1}});
  EXPECT_LE(outcome.p95_wait_ms[0], 3);
  EXPECT_GE(outcome.shown[0], 0.99);
}

TEST(RenderPacer, GoesOnWithTheOthersWhenACameraStops) {
  for (const double phase : {2.0, 12.0, 20.0, 30.0}) {
    const Outcome outcome = run({{.phase_ms = 0, .stops_at_ms = 10'000}, {.phase_ms = phase}});
    EXPECT_GE(outcome.views_per_second, 29.5) << phase;
    EXPECT_LE(outcome.p95_wait_ms[1], 20) << phase;
  }
}

TEST(RenderPacer, DoesNotWaitForASlowCamerasFrameEachTime) {
  const Outcome outcome = run({{.phase_ms = 0}, {.phase_ms = 20, .period_ms = 2 * kPeriodMs}});
  EXPECT_GE(outcome.views_per_second, 29.5);
  EXPECT_LE(outcome.p95_wait_ms[0], 8);
  EXPECT_LE(outcome.p95_wait_ms[1], kPeriodMs - 20 + 9);
}

TEST(RenderPacer, RendersForEveryCameraWhereThatIsAllowed) {
  const Outcome outcome = run({{.phase_ms = 0}, {.phase_ms = 16}}, 60, 5);
  EXPECT_GE(outcome.views_per_second, 59);
  EXPECT_LE(outcome.worst_p95(), 6);
}

TEST(RenderPacer, DoesNotAddUpLagWhenRenderingIsSlow) {
  const Outcome outcome = run({{.phase_ms = 0}, {.phase_ms = 15}}, 30, 40);
  EXPECT_GE(outcome.views_per_second, 24.5);
  EXPECT_LE(outcome.worst_p95(), 40);
}

}  // namespace
}  // namespace copresence::pacing
