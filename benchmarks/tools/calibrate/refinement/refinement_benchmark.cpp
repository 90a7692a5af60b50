// Measures accuracy and time of refinement. It uses the 50 random layouts of the calibration
// benchmark, with their cameras in the simulated room. Refinement starts from the poses of a marker
// calibration and from less accurate poses. Making the layouts takes about four minutes. Set
// COPRESENCE_LAYOUTS=N for the first N layouts, or COPRESENCE_LAYOUTS=M-N for those from M up to N,
// so that several processes can share the work. Standard error has one line per camera.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

#include "simulation/sensor/simulated_kinect.h"
#include "tests/tools/calibrate/geometry/rig.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/refinement/refinement.h"

namespace copresence::calibrate {
namespace {

struct Layout {
  int number = 0;
  std::vector<Rigid3> truth, by_markers;
  std::vector<double> marker_errors_m;  // The errors that the marker calibration expects.
  std::vector<Surface> surfaces;
};

constexpr int kFrames = 10;
const Eigen::Vector3d kMiddle(0, -1, 0.3);  // The middle of the volume that all cameras see.

Rigid3 pushed(const Rigid3& pose, std::mt19937& random, double metres, double degrees) {
  std::normal_distribution<double> number;
  const auto direction = [&] {
    const double x = number(random), y = number(random), z = number(random);
    return Eigen::Vector3d(x, y, z).normalized();
  };
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180, direction()).toRotationMatrix();
  const Eigen::Vector3d ahead = pose * Eigen::Vector3d(0, 0, 2);  // The centre of the rotation.
  return {turn * pose.rotation, turn * (pose.translation - ahead) + ahead + metres * direction()};
}

// Makes a layout of two to four Kinects in the room. Their poses are found by six markers, which do
// not appear in the surfaces.
Layout make_layout(const std::shared_ptr<const simulation::LitScene>& world, int number) {
  const int cameras = number < 18 ? 2 : number < 34 ? 3 : 4;
  const Rig rig = make_rig(static_cast<std::uint32_t>(1000 + number), cameras);
  const auto found =
      fit_world(measure(rig, kFrames).by_plane, rig.names(), {0, rig.world_from_camera[0], Solver::kRigid})
          .value();
  const Rigid3 room_from_rig{Eigen::Matrix3d::Identity(), kMiddle};
  Layout layout;
  layout.number = number;
  for (std::size_t i = 0; i < rig.world_from_camera.size(); ++i) {
    layout.truth.push_back(room_from_rig * rig.world_from_camera[i]);
    layout.by_markers.push_back(room_from_rig * found.cameras[i].world_from_camera);
    layout.marker_errors_m.push_back(found.cameras[i].expected_shift_m);
  }
  for (std::size_t i = 0; i < layout.truth.size(); ++i) {
    auto kinect =
        simulation::SimulatedKinect::make(world, rig.model, layout.truth, i, DepthUnit::kMillimetre, rig.seed)
            .value();
    DepthAverage average(DepthUnit::kMillimetre);
    DepthImage depth;
    ColorImage color;
    for (int frame = 0; frame < kFrames; ++frame) {
      kinect.capture(0.3, static_cast<std::uint64_t>(frame), depth, color);
      average.add(depth);
    }
    layout.surfaces.push_back(make_surface(average.still_depth(), rig.model));
  }
  return layout;
}

const std::vector<Layout>& layouts() {
  static const std::vector<Layout> kLayouts = [] {
    int first = 0, end = 50;
    if (const char* which = std::getenv("COPRESENCE_LAYOUTS")) {
      const char* dash = std::strchr(which, '-');
      first = dash ? std::atoi(which) : 0;
      end = std::atoi(dash ? dash + 1 : which);
    }
    const auto world =
        std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
    std::vector<Layout> made;
    for (int number = first; number < end; ++number) {
      made.push_back(make_layout(world, number));
    }
    return made;
  }();
  return kLayouts;
}

// Returns the mean shift of points in the shared volume, a cube of 1.6 m, in millimetres.
double shift_mm(const Rigid3& found, const Rigid3& truth) {
  const Rigid3 motion = found * truth.inverse();
  double sum = 0;
  int points = 0;
  for (double x = -0.8; x <= 0.81; x += 0.4) {
    for (double y = -0.8; y <= 0.81; y += 0.4) {
      for (double z = -0.8; z <= 0.81; z += 0.4, ++points) {
        const Eigen::Vector3d point = kMiddle + Eigen::Vector3d(x, y, z);
        sum += 1000 * (motion * point - point).norm();
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

enum Start : int { kMarkers, kPushed };

// Refines from the poses of the marker calibration, or from wrong poses. Arguments are the error in
// tenths of a millimetre, the error in thousandths of a degree, and whether refinement knows the
// error. A marker calibration must be accurate to 4 mm and 0.15 degrees. A tape measure is
// typically accurate to 100 mm and 5 degrees.
void refine_simulated_layouts(benchmark::State& state) {
  const double metres = static_cast<double>(state.range(1)) * 1e-4,
               degrees = static_cast<double>(state.range(2)) * 1e-3;
  std::vector<double> before, after, angles, expected;
  int worse = 0, kept = 0, runs = 0, alone = 0;
  double most_worse = 0;
  for (auto _ : state) {
    for (const Layout& layout : layouts()) {
      std::mt19937 random(static_cast<unsigned>(1000 + layout.number));
      std::vector<Rigid3> given = layout.by_markers;
      std::vector<double> errors_m = layout.marker_errors_m;
      if (state.range(0) == kPushed) {
        given = layout.truth;
        for (std::size_t i = 1; i < given.size(); ++i) given[i] = pushed(given[i], random, metres, degrees);
        const double known_m = std::hypot(metres, degrees * std::numbers::pi / 180 * 0.6);
        errors_m.assign(given.size(), state.range(3) ? known_m : 0);
      }
      const Refinement refined = refine(layout.surfaces, given, errors_m);
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
        if (camera.surfaces_mm > 0) expected.push_back(camera.surfaces_mm);
        alone += camera.outcome == CameraRefinement::Outcome::kNoOverlap;
        kept += camera.moved_mm == 0;
        worse += is > was + 1e-6;
        most_worse = std::max(most_worse, is - was);
        std::fprintf(
            stderr,
            "layout %d camera %zu of %zu: %.2f to %.2f mm, told %.2f, surfaces know %.2f, expects %.2f, "
            "outcome %d\n",
            layout.number, i, given.size() - 1, was, is, camera.prior_mm, camera.surfaces_mm, camera.error_mm,
            static_cast<int>(camera.outcome));
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
  state.counters["surfaces_say_p50_mm"] = quantile(expected, 0.5);
  state.counters["worse"] = worse;
  state.counters["most_worse_mm"] = most_worse;
  state.counters["kept"] = kept;
  state.counters["no_overlap"] = alone;
}
BENCHMARK(refine_simulated_layouts)
    ->Args({kMarkers, 0, 0, 1})
    ->Args({kPushed, 40, 150, 1})
    ->Args({kPushed, 40, 150, 0})
    ->Args({kPushed, 1000, 5000, 0})
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
}  // namespace copresence::calibrate
