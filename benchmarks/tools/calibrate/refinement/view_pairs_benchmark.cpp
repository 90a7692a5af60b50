// Measures the accuracy of refinement on pairs of single views, from three sources. Some are views
// of a real office with known poses. Some are from a recording of a camera that moves through that
// office, with poses tracked by this benchmark. The others are from a simulated Kinect, with true
// poses. Each pair starts from the known pose and from wrong poses, with errors of 10 cm and 5
// degrees. COPRESENCE_STARTS sets the number of wrong poses, 12 by default. Generalised ICP starts
// from some of the same poses.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/tools/calibrate/refinement/generalized_icp.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tests/support/real_recordings.h"
#include "tools/calibrate/capture.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/refinement/icp.h"
#include "tools/calibrate/refinement/refinement.h"

namespace copresence::calibrate {
namespace {

constexpr int kSimulatedViews = 10;

struct View {
  Surface surface;
  Rigid3 world_from_camera;  // The known pose.
};

// Returns the depth of a single frame, in metres.
Image<float> depth_of(const DepthImage& depth, DepthUnit unit) {
  DepthAverage average(unit);
  average.add(depth);
  return average.still_depth();
}

std::vector<Surface> surfaces_of(const std::string& path, int step, int most = 1000) {
  std::vector<Surface> surfaces;
  auto capture = Capture::open({"view", path, false, {}}, nullptr);
  if (!capture) return surfaces;
  for (int number = 0; number < most * step; ++number) {
    const auto frame = capture->next();
    if (!frame) break;
    if (number % step == 0) {
      surfaces.push_back(make_surface(depth_of(frame->depth, capture->unit()), capture->model()));
    }
  }
  return surfaces;
}

// Refines all views together, which removes the drift of tracking. It uses all pairs of near views
// and a third of the other pairs with much overlap.
void lay_together(const std::vector<Surface>& surfaces, std::vector<Rigid3>& poses) {
  constexpr std::array<IcpLevel, 2> kLevels{{{0.1, 16, 10}, {0.05, 8, 15}}};
  IcpProblem all{surfaces, {}, {}};
  for (std::size_t i = 1; i < surfaces.size(); ++i) all.moving.push_back(i);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    for (std::size_t j = i + 1; j < surfaces.size(); ++j) {
      if (j - i > 3 && (i + j) % 3) continue;
      const double overlap = measure_agreement(surfaces[i], poses[i], surfaces[j], poses[j], 8).overlap;
      if (overlap > 0.3) all.pairs.emplace_back(i, j);
    }
  }
  run_icp(all, kLevels, {}, poses);
}

// Tracks a moving camera: registers each view to the previous view and to older overlapping views.
std::vector<View> track(std::vector<Surface> surfaces) {
  constexpr std::array<IcpLevel, 3> kLevels{{{0.15, 8, 10}, {0.08, 8, 10}, {0.05, 4, 15}}};
  std::vector<Rigid3> poses(surfaces.size());
  for (std::size_t i = 1; i < surfaces.size(); ++i) {
    const Rigid3 motion = i > 1 ? poses[i - 2].inverse() * poses[i - 1] : Rigid3{};
    poses[i] = poses[i - 1] * motion;
    IcpProblem last{surfaces, {i}, {{i - 1, i}}};
    run_icp(last, kLevels, {}, poses);
    IcpProblem all = last;
    for (const std::size_t back : {4, 8, 14, 20, 28, 40}) {
      if (back > i) break;
      const double overlap =
          measure_agreement(surfaces[i - back], poses[i - back], surfaces[i], poses[i], 8).overlap;
      if (overlap > 0.3) all.pairs.emplace_back(i - back, i);
    }
    run_icp(all, std::span(kLevels).subspan(1), {}, poses);
  }
  lay_together(surfaces, poses);
  std::vector<View> views;
  for (std::size_t i = 0; i < surfaces.size(); ++i) views.push_back({std::move(surfaces[i]), poses[i]});
  return views;
}

std::vector<View> office_views() {
  std::vector<View> views;
  const auto poses = test::real_recording("office_views.json");
  if (!poses) return views;
  const nlohmann::json told = nlohmann::json::parse(std::ifstream(*poses));
  for (const auto& camera : told["cameras"]) {
    const auto path = test::real_recording(camera["file"]);
    if (!path) return {};
    View view{surfaces_of(*path, 1, 1).at(0), {}};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) view.world_from_camera.rotation(r, c) = camera["world_from_camera"][r][c];
      view.world_from_camera.translation[r] = camera["world_from_camera"][r][3];
    }
    views.push_back(std::move(view));
  }
  return views;
}

// Returns the views of a Kinect that moves around the motionless person of the simulated room, at
// changing distance, height and direction.
std::vector<View> simulated_views() {
  const auto world =
      std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
  const CameraModel model = simulation::kinect_model(640, 480);
  std::vector<View> views;
  for (int i = 0; i < kSimulatedViews; ++i) {
    const double around = (-60.0 + 13 * i) * std::numbers::pi / 180, way = i;
    const double distance = 1.65 + 0.12 * std::sin(1.3 * way);
    const Rigid3 pose = simulation::look_from(
        {distance * std::sin(around), -1.4 + 0.25 * std::sin(2.1 * way), -distance * std::cos(around)},
        {0.4 * std::cos(1.7 * way), -0.9, 0});
    auto kinect = simulation::SimulatedKinect::make(world, model, std::vector{pose}, 0,
                                                    DepthUnit::kMillimetre, static_cast<std::uint32_t>(i))
                      .value();
    DepthImage depth;
    ColorImage color;
    kinect.capture(0.3, 0, depth, color);
    views.push_back({make_surface(depth_of(depth, DepthUnit::kMillimetre), model), pose});
  }
  return views;
}

enum Recording : int { kViews, kOffice, kSimulated };
constexpr int kStep = 3;        // Number of frames from one tracked view to the next.
constexpr int kGicpStarts = 2;  // Generalised ICP gets fewer starts, because it takes longer.

const std::vector<View>& views_of(int recording) {
  static std::map<int, std::vector<View>> all;
  const auto [entry, fresh] = all.try_emplace(recording);
  if (!fresh) return entry->second;
  if (recording == kViews) {
    entry->second = office_views();
  } else if (recording == kSimulated) {
    entry->second = simulated_views();
  } else if (const auto path = test::real_recording("office.oni")) {
    entry->second = track(surfaces_of(*path, kStep));
  }
  return entry->second;
}

double millimetres(const Rigid3& a, const Rigid3& b) {
  return 1000 * (a.translation - b.translation).norm();
}
double degrees(const Rigid3& a, const Rigid3& b) {
  return Eigen::AngleAxisd(a.rotation.transpose() * b.rotation).angle() * 180 / std::numbers::pi;
}

Rigid3 pushed(const Rigid3& pose, std::mt19937& random) {
  std::normal_distribution<double> number;
  const auto direction = [&] {
    const double x = number(random), y = number(random), z = number(random);
    return Eigen::Vector3d(x, y, z).normalized();
  };
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(5 * std::numbers::pi / 180, direction()).toRotationMatrix();
  return {turn * pose.rotation, pose.translation + 0.1 * direction()};
}

// The arguments are a Recording, the index of the first view and the index of the second view.
void refine_a_pair(benchmark::State& state) {
  const std::vector<View>& views = views_of(static_cast<int>(state.range(0)));
  const auto i = static_cast<std::size_t>(state.range(1)), j = static_cast<std::size_t>(state.range(2));
  if (std::max(i, j) >= views.size()) {
    state.SkipWithError("SKIPPED: the real recordings are not on this machine (set COPRESENCE_RECORDINGS)");
    return;
  }
  const View &a = views[i], &b = views[j];
  const char* count = std::getenv("COPRESENCE_STARTS");
  const int starts = count ? std::atoi(count) : 12;
  const std::vector surfaces{a.surface, b.surface};
  const Cloud cloud_a = make_cloud(a.surface), cloud_b = make_cloud(b.surface);
  const auto refined = [&](const Rigid3& start) {
    return refine(surfaces, std::vector{a.world_from_camera, start}, std::vector(2, 0.0));
  };
  const auto gicp = [&](const Rigid3& start) {
    return a.world_from_camera *
           generalized_icp(cloud_b, cloud_a, a.world_from_camera.inverse() * start, 0.2);
  };
  std::mt19937 random(
      static_cast<unsigned>(state.range(0) * 1000000 + state.range(1) * 1000 + state.range(2)));
  for (auto _ : state) {
    const Refinement untouched = refined(b.world_from_camera);
    const Rigid3 home = untouched.cameras[1].world_from_camera, gicp_home = gicp(b.world_from_camera);
    double apart_mm = 0, apart_deg = 0, pushed_mm = 0, pushed_deg = 0, gicp_mm = 0, gicp_deg = 0;
    int elsewhere = 0, not_refined = 0, gicp_elsewhere = 0;
    for (int start = 0; start < starts; ++start) {
      const Rigid3 from = pushed(b.world_from_camera, random);
      const Refinement end = refined(from);
      const Rigid3 there = end.cameras[1].world_from_camera;
      not_refined += end.cameras[1].outcome != CameraRefinement::Outcome::kRefined;
      elsewhere += millimetres(there, home) > 2 || degrees(there, home) > 0.1;
      apart_mm = std::max(apart_mm, millimetres(there, home));
      apart_deg = std::max(apart_deg, degrees(there, home));
      pushed_mm = std::max(pushed_mm, millimetres(there, b.world_from_camera));
      pushed_deg = std::max(pushed_deg, degrees(there, b.world_from_camera));
      if (start >= kGicpStarts) continue;
      const Rigid3 gicp_end = gicp(from);
      gicp_mm = std::max(gicp_mm, millimetres(gicp_end, b.world_from_camera));
      gicp_deg = std::max(gicp_deg, degrees(gicp_end, b.world_from_camera));
      gicp_elsewhere += millimetres(gicp_end, gicp_home) > 2 || degrees(gicp_end, gicp_home) > 0.1;
    }
    state.counters["baseline_mm"] = millimetres(a.world_from_camera, b.world_from_camera);
    state.counters["baseline_deg"] = degrees(a.world_from_camera, b.world_from_camera);
    state.counters["overlap"] = untouched.pairs.empty() ? 0 : 100 * untouched.pairs.front().after.overlap;
    state.counters["mm"] = millimetres(home, b.world_from_camera);
    state.counters["deg"] = degrees(home, b.world_from_camera);
    state.counters["pushed_mm"] = pushed_mm;
    state.counters["pushed_deg"] = pushed_deg;
    state.counters["apart_mm"] = apart_mm;
    state.counters["apart_deg"] = apart_deg;
    state.counters["elsewhere"] = elsewhere;
    state.counters["not_refined"] =
        not_refined + (untouched.cameras[1].outcome != CameraRefinement::Outcome::kRefined);
    state.counters["frozen"] = static_cast<double>(untouched.cameras[1].unobservable.size());
    state.counters["gicp_home_mm"] = millimetres(gicp_home, b.world_from_camera);
    state.counters["gicp_home_deg"] = degrees(gicp_home, b.world_from_camera);
    state.counters["gicp_mm"] = gicp_mm;
    state.counters["gicp_deg"] = gicp_deg;
    state.counters["gicp_elsewhere"] = gicp_elsewhere;
  }
}

void each_pair(benchmark::internal::Benchmark* all) {
  all->Args({kViews, 0, 1});
  for (const int apart : {16, 26, 38}) {
    for (int first = 0; first + apart < 50; first += 10) all->Args({kOffice, first, first + apart});
  }
  for (const int apart : {1, 2, 3}) {
    for (int first = apart - 1; first + apart < kSimulatedViews; first += 2)
      all->Args({kSimulated, first, first + apart});
  }
}
BENCHMARK(refine_a_pair)->Apply(each_pair)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::calibrate
