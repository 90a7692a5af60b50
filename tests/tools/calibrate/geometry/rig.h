#pragma once

// Random cameras and markers, a Kinect's measurements of them, and the error of a result.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "simulation/sensor/kinect_depth.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tools/calibrate/geometry/marker_layout.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/geometry/world_fit.h"

namespace copresence::calibrate {

inline constexpr double kMarkerSize = 0.20;    // metres
inline constexpr double kBoardSize = 0.26;     // With its white border.
inline constexpr double kCornerNoisePx = 0.1;  // Error of a corner detector.

struct Rig {
  CameraModel model = simulation::kinect_model(640, 480);
  std::vector<Rigid3> world_from_camera;
  std::vector<Rigid3> world_from_marker;  // The marker lies in its own x, y plane.
  std::uint32_t seed = 0;

  RigNames names() const {
    RigNames names;
    for (std::size_t c = 0; c < world_from_camera.size(); ++c)
      names.cameras.push_back("camera" + std::to_string(c));
    for (std::size_t m = 0; m < world_from_marker.size(); ++m) names.markers.push_back(std::to_string(m));
    return names;
  }
};

/// The corners of a square in the marker's own plane.
inline std::vector<Eigen::Vector3d> square(double size) {
  const double h = size / 2;
  return {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
}

/// Cameras stand at least 35 degrees apart in front of a shared volume of 1.6 m. All markers are in
/// every picture, 1 to 3 m away, at most 63 degrees from their normal.
inline Rig make_rig(std::uint32_t seed, int cameras, int markers = 6) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (;;) {
    Rig rig;
    rig.seed = seed;
    for (int c = 0; c < cameras; ++c) {
      const double angle = ((c - 0.5 * (cameras - 1)) * 40 + between(-3, 3)) * std::numbers::pi / 180;
      const double distance = between(1.9, 2.3);
      rig.world_from_camera.push_back(
          simulation::look_from({distance * std::sin(angle), between(-0.7, 0.2), -distance * std::cos(angle)},
                                {between(-0.1, 0.1), between(-0.1, 0.1), between(-0.1, 0.1)}));
    }
    Eigen::Vector3d front = Eigen::Vector3d::Zero();
    for (const Rigid3& pose : rig.world_from_camera) front += pose.translation / cameras;
    std::vector<NamedPoint> points;
    for (int tries = 0; tries < 4000 && int(rig.world_from_marker.size()) < markers; ++tries) {
      const Eigen::Vector3d middle(between(-0.8, 0.8), between(-0.6, 0.6), between(-0.8, 0.8));
      const Rigid3 facing =
          simulation::look_from(middle, front + Eigen::Vector3d(between(-1, 1), between(-1, 1), 0));
      bool good = std::all_of(points.begin(), points.end(),
                              [&](const NamedPoint& p) { return (p.position - middle).norm() > 0.35; });
      for (const Rigid3& pose : rig.world_from_camera) {
        const auto circle = [&](const Eigen::Vector3d& in_world) {  // Circle around the board and its shadow.
          const Eigen::Vector3d p = pose.inverse() * in_world;
          const Eigen::Vector2d at = p.z() > 0.5 ? project(rig.model, p) : Eigen::Vector2d(-1e9, -1e9);
          return Eigen::Vector3d(at.x(), at.y(), 0.8 * kBoardSize * rig.model.fx / std::max(0.5, p.z()));
        };
        good = good && facing.rotation.col(2).dot((pose.translation - middle).normalized()) > 0.45;
        for (const NamedPoint& other : points) {
          const Eigen::Vector3d a = circle(middle), b = circle(other.position);
          good = good && (a - b).head<2>().norm() > a.z() + b.z();
        }
        for (const Eigen::Vector3d& corner : square(kBoardSize)) {
          const Eigen::Vector3d p = pose.inverse() * (facing * corner);
          good = good && p.z() > 1 && p.z() < 3;
          if (!good) break;
          const Eigen::Vector2d pixel = project(rig.model, p);
          good = pixel.x() > 5 && pixel.x() < 625 && pixel.y() > 5 && pixel.y() < 475;
        }
      }
      if (!good) continue;
      rig.world_from_marker.push_back(facing);
      points.push_back({"", middle});
    }
    if (int(points.size()) == markers && check_layout(points, Solver::kLinear, "")) return rig;
    seed += 1000003;
    random.seed(seed);
  }
}

/// Observations of one marker by one camera: rays to its centre and corners, with the noise of a
/// corner detector. `depth_at` returns the measured depth along a ray, metres.
template <class DepthAt>
void sight(const Rig& rig, std::size_t camera, std::size_t marker, std::mt19937& random, DepthAt&& depth_at,
           std::vector<Observation>& observations) {
  std::normal_distribution<double> noise(0, kCornerNoisePx);
  std::vector<Eigen::Vector3d> points = square(kMarkerSize);
  points.insert(points.begin(), Eigen::Vector3d::Zero());
  for (std::size_t part = 0; part < points.size(); ++part) {
    Eigen::Vector2d pixel = project(
        rig.model, rig.world_from_camera[camera].inverse() * (rig.world_from_marker[marker] * points[part]));
    const double share = part == 0 ? 0.5 : 1.0;  // The centre is computed from four corners.
    pixel += share * Eigen::Vector2d(noise(random), noise(random));
    Observation observation;
    observation.camera = camera;
    observation.marker = marker;
    observation.part = static_cast<int>(part);
    observation.ray = unproject(rig.model, pixel, 1).head<2>();
    observation.z_m = depth_at(observation.ray);
    if (part > 0) observation.inverse_z_sigma = kUnknownDepth;
    observations.push_back(observation);
  }
}

/// Observations of all markers by all cameras. The depth of a marker has a normal error of `levels`
/// disparity steps.
inline std::vector<Observation> observations_with_noise(const Rig& rig, double levels) {
  std::mt19937 random(rig.seed + 17);
  std::normal_distribution<double> error(0, levels / 351.3);
  std::vector<Observation> observations;
  for (std::size_t c = 0; c < rig.world_from_camera.size(); ++c) {
    for (std::size_t m = 0; m < rig.world_from_marker.size(); ++m) {
      const Rigid3 camera_from_marker = rig.world_from_camera[c].inverse() * rig.world_from_marker[m];
      const Eigen::Vector3d normal = camera_from_marker.rotation.col(2);
      const double wrong = levels > 0 ? error(random) : 0,
                   on_plane = normal.dot(camera_from_marker.translation);
      sight(
          rig, c, m, random,
          [&](const Eigen::Vector2d& ray) { return 1 / (normal.dot(ray.homogeneous()) / on_plane + wrong); },
          observations);
    }
  }
  return observations;
}

/// The view of a perfect camera: the boards of the markers in front of a wall at 4 m.
inline simulation::TrueView view_of(const Rig& rig, std::size_t camera) {
  simulation::TrueView view;
  view.depth_m = Image<float>(rig.model.width, rig.model.height, 4.0f);
  view.infrared = Image<float>(rig.model.width, rig.model.height, 0.5f);
  for (const Rigid3& marker : rig.world_from_marker) {
    const Rigid3 camera_from_marker = rig.world_from_camera[camera].inverse() * marker;
    const Rigid3 marker_from_camera = camera_from_marker.inverse();
    Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
    for (const Eigen::Vector3d& corner : square(kBoardSize)) {
      const Eigen::Vector2d pixel = project(rig.model, camera_from_marker * corner);
      low = low.cwiseMin(pixel);
      high = high.cwiseMax(pixel);
    }
    const Eigen::Vector3d eye = marker_from_camera.translation;
    for (int y = int(low.y()); y <= int(high.y()) + 1; ++y) {
      for (int x = int(low.x()); x <= int(high.x()) + 1; ++x) {
        const Eigen::Vector3d ray =
            marker_from_camera.rotation * unproject(rig.model, {double(x), double(y)}, 1);
        const double z = -eye.z() / ray.z();
        const Eigen::Vector3d hit = eye + z * ray;
        if (hit.head<2>().cwiseAbs().maxCoeff() > kBoardSize / 2) continue;
        float& depth = view.depth_m(x, y);
        if (z > 0 && z < depth) depth = static_cast<float>(z);
      }
    }
  }
  return view;
}

/// Whether nothing covers a part of the marker. A partly covered marker is not detected.
inline bool is_seen(const Rig& rig, std::size_t camera, std::size_t marker,
                    const simulation::TrueView& view) {
  for (double x = -0.5; x <= 0.51; x += 0.25) {
    for (double y = -0.5; y <= 0.51; y += 0.25) {
      const Eigen::Vector3d point =
          rig.world_from_camera[camera].inverse() *
          (rig.world_from_marker[marker] * Eigen::Vector3d(x * kMarkerSize, y * kMarkerSize, 0));
      const Eigen::Vector2d pixel = project(rig.model, point);
      if (std::abs(view.depth_m(int(pixel.x() + 0.5), int(pixel.y() + 0.5)) - point.z()) > 0.02) return false;
    }
  }
  return true;
}

/// Observations through KinectNoise over `frames` frames. Depth is that of a plane fitted to the
/// marker or, for comparison, the mean of the pixel at its centre.
struct Measured {
  std::vector<Observation> by_plane, by_pixel;
  double plane_error_steps = 0, pixel_error_steps = 0;  // Root mean square error of depth at the centres.
};
inline Measured measure(const Rig& rig, int frames) {
  Measured out;
  std::mt19937 random(rig.seed + 29);
  double count = 0;
  for (std::size_t c = 0; c < rig.world_from_camera.size(); ++c) {
    const simulation::TrueView view = view_of(rig, c);
    simulation::KinectNoise noise(rig.model, DepthUnit::kMillimetre, rig.seed, static_cast<std::uint32_t>(c));
    DepthAverage average(DepthUnit::kMillimetre);
    simulation::DotImage dots;
    simulation::project_dots(rig.model, view, dots);
    DepthImage depth(rig.model.width, rig.model.height);
    for (int frame = 0; frame < frames; ++frame) {
      noise.add_noise(dots, static_cast<std::uint64_t>(frame), depth.pixels());
      average.add(depth);
    }
    for (std::size_t m = 0; m < rig.world_from_marker.size(); ++m) {
      if (!is_seen(rig, c, m, view)) continue;
      const Rigid3 camera_from_marker = rig.world_from_camera[c].inverse() * rig.world_from_marker[m];
      std::vector<Eigen::Vector2d> outline;
      for (const Eigen::Vector3d& corner : square(kMarkerSize)) {
        outline.push_back(project(rig.model, camera_from_marker * corner));
      }
      const auto plane = fit_plane(average, rig.model, outline);
      const Eigen::Vector2d middle = project(rig.model, camera_from_marker.translation);
      const double at_pixel = average.inverse_depth(int(middle.x() + 0.5), int(middle.y() + 0.5));
      const double z = camera_from_marker.translation.z();
      if (!plane || at_pixel <= 0) continue;  // In the shadow of another marker.
      const std::mt19937 same_noise = random;
      sight(
          rig, c, m, random, [&](const Eigen::Vector2d& ray) { return plane->z_along(ray); }, out.by_plane);
      random = same_noise;
      sight(
          rig, c, m, random, [&](const Eigen::Vector2d&) { return 1 / at_pixel; }, out.by_pixel);
      const Eigen::Vector2d ray = camera_from_marker.translation.head<2>() / z;
      out.plane_error_steps += std::pow((1 / plane->z_along(ray) - 1 / z) * 351.3, 2);
      out.pixel_error_steps += std::pow((at_pixel - 1 / z) * 351.3, 2);
      ++count;
    }
  }
  out.plane_error_steps = std::sqrt(out.plane_error_steps / count);
  out.pixel_error_steps = std::sqrt(out.pixel_error_steps / count);
  return out;
}

/// Error of a pose, relative to the reference camera.
struct PoseError {
  double shift_mm = 0;  // Mean over the shared volume.
  double angle_deg = 0;
};
inline PoseError pose_error(const Rig& rig, std::size_t camera, const Rigid3& world_from_camera) {
  const Rigid3 off = world_from_camera * rig.world_from_camera[camera].inverse();
  PoseError error;
  int count = 0;
  for (double x = -0.8; x <= 0.81; x += 0.4) {
    for (double y = -0.8; y <= 0.81; y += 0.4) {
      for (double z = -0.8; z <= 0.81; z += 0.4, ++count) {
        const Eigen::Vector3d point(x, y, z);
        error.shift_mm += 1000 * (off * point - point).norm();
      }
    }
  }
  error.shift_mm /= count;
  error.angle_deg = Eigen::AngleAxisd(off.rotation).angle() * 180 / std::numbers::pi;
  return error;
}

/// Errors over many layouts.
struct Errors {
  std::vector<double> shift_mm, angle_deg;
  double squared_shift = 0, squared_expectation = 0;  // metres^2

  void add(const Rig& rig, const WorldFit& fit) {
    for (std::size_t c = 1; c < fit.cameras.size(); ++c) {
      const PoseError error = pose_error(rig, c, fit.cameras[c].world_from_camera);
      shift_mm.push_back(error.shift_mm);
      angle_deg.push_back(error.angle_deg);
      squared_shift += std::pow(error.shift_mm * 1e-3, 2);
      squared_expectation += std::pow(fit.cameras[c].expected_shift_m, 2);
    }
  }
  /// Expected errors relative to true errors.
  double expected_over_actual() const { return std::sqrt(squared_expectation / squared_shift); }

  static double at(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  }
};

struct LayoutErrors {
  Errors rigid, linear, of_one_pixel;
  double plane_steps = 0, pixel_steps = 0;  // Mean over the layouts.
  int refused = 0, linear_refused = 0;
};
/// Runs the layouts from `first` up to `last` of 50: 18 with two cameras, 16 with three and 16 with
/// four, all with six markers.
inline LayoutErrors run_layouts(int first, int last, int frames) {
  LayoutErrors out;
  for (int layout = first; layout < last; ++layout) {
    const int cameras = layout < 18 ? 2 : layout < 34 ? 3 : 4;
    const Rig rig = make_rig(static_cast<std::uint32_t>(1000 + layout), cameras);
    const Measured measured = measure(rig, frames);
    out.plane_steps += measured.plane_error_steps / (last - first);
    out.pixel_steps += measured.pixel_error_steps / (last - first);
    const auto fit = [&](const std::vector<Observation>& observations, Solver solver) {
      return fit_world(observations, rig.names(), {0, rig.world_from_camera[0], solver});
    };
    const auto rigid = fit(measured.by_plane, Solver::kRigid), pixel = fit(measured.by_pixel, Solver::kRigid);
    const auto linear = fit(measured.by_plane, Solver::kLinear);
    if (rigid) out.rigid.add(rig, *rigid);
    if (pixel) out.of_one_pixel.add(rig, *pixel);
    if (linear) out.linear.add(rig, *linear);
    out.refused += rigid ? 0 : 1;
    out.linear_refused += linear ? 0 : 1;
  }
  return out;
}

}  // namespace copresence::calibrate
