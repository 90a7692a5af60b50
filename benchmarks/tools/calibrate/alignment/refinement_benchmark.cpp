// Time of one refinement, and how good it is: on seeded layouts of cameras in the simulated room with known truth, and
// on the shared real views. Layouts are made once, about a minute for all of them.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <vector>

#include "capture_server/simulation/simulated_kinect.h"
#include "tools/calibrate/alignment/refinement.h"
#include "tools/calibrate/alignment/static_depth.h"

namespace copresence::alignment {
namespace {

struct Layout {
  std::vector<Rigid3> truth;
  std::vector<Surface> surfaces;
};

constexpr int kFrames = 8;

Rigid3 pushed(const Rigid3& pose, std::mt19937& random, double metres, double degrees) {
  std::normal_distribution<double> number;
  const auto direction = [&] {
    const double x = number(random), y = number(random), z = number(random);
    return Eigen::Vector3d(x, y, z).normalized();
  };
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180, direction()).toRotationMatrix();
  const Eigen::Vector3d ahead = pose * Eigen::Vector3d(0, 0, 2);  // turned about what it looks at
  return {turn * pose.rotation, turn * (pose.translation - ahead) + ahead + metres * direction()};
}

// Two to four Kinects around the middle of the room, never twice the same.
Layout make_layout(const std::shared_ptr<const simulation::World>& world, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1, 1);
  const int cameras = 2 + static_cast<int>(seed % 3);
  Layout layout;
  double angle = std::numbers::pi * within(random);
  for (int i = 0; i < cameras; ++i) {
    const double distance = 1.9 + 0.3 * within(random);
    layout.truth.push_back(simulation::look_from(
        {distance * std::sin(angle), -1.5 + 0.4 * within(random), -distance * std::cos(angle)},
        {0.3 * within(random), -0.9 + 0.2 * within(random), 0.3 * within(random)}));
    angle += (50 + 20 * within(random)) * std::numbers::pi / 180;
  }
  const CameraModel model = simulation::kinect_model(640, 480);
  for (std::size_t i = 0; i < layout.truth.size(); ++i) {
    auto kinect =
        simulation::SimulatedKinect::make(world, model, layout.truth, i, DepthUnit::kMillimetre, seed)
            .value();
    std::vector<DepthImage> frames(kFrames);
    ColorImage color;
    for (int frame = 0; frame < kFrames; ++frame) {
      kinect.expose(0.3, static_cast<std::uint64_t>(frame), frames[static_cast<std::size_t>(frame)], color);
    }
    layout.surfaces.push_back(make_surface(static_depth(frames, DepthUnit::kMillimetre), model));
  }
  return layout;
}

const std::vector<Layout>& layouts() {
  static const std::vector<Layout> kLayouts = [] {
    const char* count = std::getenv("COPRESENCE_LAYOUTS");
    const auto world = std::make_shared<const simulation::World>(simulation::World::make("room").value());
    std::vector<Layout> made;
    for (unsigned seed = 1; seed <= static_cast<unsigned>(count ? std::atoi(count) : 50); ++seed) {
      made.push_back(make_layout(world, seed));
    }
    return made;
  }();
  return kLayouts;
}

// Mean shift of points in the volume that the cameras share, a metre around the room's middle. Millimetres.
double shift_mm(const Rigid3& found, const Rigid3& truth) {
  const Rigid3 motion = found * truth.inverse();
  double sum = 0;
  int points = 0;
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double y : {-1.5, -1.0, -0.5}) {
      for (const double z : {-0.5, 0.0, 0.5}) {
        const Eigen::Vector3d point(x, y, z);
        sum += 1000 * (motion * point - point).norm();
        ++points;
      }
    }
  }
  return sum / points;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Starts as far off as the arguments say: tenths of a millimetre and thousandths of a degree. 4 mm and 0.15 degrees
// are what markers leave, 100 mm and 5 degrees what a tape measure does. The third argument: whether the error is told.
void refine_simulated_layouts(benchmark::State& state) {
  const double metres = static_cast<double>(state.range(0)) * 1e-4,
               degrees = static_cast<double>(state.range(1)) * 1e-3;
  std::vector<double> before, after, angles;
  int worse = 0, not_refined = 0, runs = 0;
  double most_worse = 0;
  for (auto _ : state) {
    for (std::size_t number = 0; number < layouts().size(); ++number) {
      const Layout& layout = layouts()[number];
      std::mt19937 random(static_cast<unsigned>(1000 + number));
      std::vector<Rigid3> given = layout.truth;
      for (std::size_t i = 1; i < given.size(); ++i) given[i] = pushed(given[i], random, metres, degrees);
      const double known_m = state.range(2) ? std::hypot(metres, degrees * std::numbers::pi / 180 * 0.6) : 0;
      const Refinement refined = refine(layout.surfaces, given, std::vector(given.size(), known_m));
      ++runs;
      for (std::size_t i = 1; i < given.size(); ++i) {
        const CameraRefinement& camera = refined.cameras[i];
        const double was = shift_mm(given[i], layout.truth[i]),
                     is = shift_mm(camera.world_from_camera, layout.truth[i]);
        before.push_back(was);
        after.push_back(is);
        angles.push_back(
            Eigen::AngleAxisd(camera.world_from_camera.rotation.transpose() * layout.truth[i].rotation)
                .angle() *
            180 / std::numbers::pi);
        not_refined += camera.outcome != CameraRefinement::Outcome::kRefined;
        worse += is > was;
        most_worse = std::max(most_worse, is - was);
      }
    }
  }
  state.counters["layouts"] = runs;
  state.counters["cameras"] = static_cast<double>(before.size());
  state.counters["before_p50_mm"] = quantile(before, 0.5);
  state.counters["before_p95_mm"] = quantile(before, 0.95);
  state.counters["after_p50_mm"] = quantile(after, 0.5);
  state.counters["after_p95_mm"] = quantile(after, 0.95);
  state.counters["after_p50_deg"] = quantile(angles, 0.5);
  state.counters["after_p95_deg"] = quantile(angles, 0.95);
  state.counters["worse"] = worse;
  state.counters["most_worse_mm"] = most_worse;
  state.counters["not_refined"] = not_refined;
}
BENCHMARK(refine_simulated_layouts)
    ->Args({40, 150, 1})
    ->Args({40, 150, 0})
    ->Args({1000, 5000, 0})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void make_surface_of_a_frame(benchmark::State& state) {
  const Layout& layout = layouts().front();
  for (auto _ : state) {
    benchmark::DoNotOptimize(make_surface(layout.surfaces[0].depth_m, layout.surfaces[0].model));
  }
}
BENCHMARK(make_surface_of_a_frame)->Unit(benchmark::kMillisecond);

void refine_one_pair(benchmark::State& state) {
  const Layout& layout = layouts().front();
  std::mt19937 random(1);
  const std::vector<Rigid3> given{layout.truth[0], pushed(layout.truth[1], random, 0.1, 5)};
  for (auto _ : state)
    benchmark::DoNotOptimize(refine(std::span(layout.surfaces).first(2), given, std::vector(2, 0.0)));
}
BENCHMARK(refine_one_pair)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace copresence::alignment
