#pragma once

// Walls and boxes at known positions, seen by cameras of known pose.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate::test {

inline CameraModel small_camera() {
  return {320, 240, 292.5, 292.5, 160, 120, {}};
}

struct Box {
  Eigen::Vector3d min, max;  ///< Seen from outside, or from inside if the eye is in it.
};

/// Distance along `way` at which a ray from `eye` enters a box, or leaves it if the eye is inside;
/// 0 if it misses.
inline double meet(const Box& box, const Eigen::Vector3d& eye, const Eigen::Vector3d& way) {
  double in = -1e9, out = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(way[axis]) < 1e-12) {
      if (eye[axis] < box.min[axis] || eye[axis] > box.max[axis]) return 0;
      continue;
    }
    double first = (box.min[axis] - eye[axis]) / way[axis], second = (box.max[axis] - eye[axis]) / way[axis];
    if (first > second) std::swap(first, second);
    in = std::max(in, first);
    out = std::min(out, second);
  }
  if (in > out || out <= 0) return 0;
  return in > 0 ? in : out;
}

/// Depth in metres. A `seed` other than 0 adds a Kinect's noise: half a disparity step, in blobs of
/// 4 pixels.
inline Image<float> depth_of(const std::vector<Box>& boxes, const CameraModel& camera,
                             const Rigid3& world_from_camera, unsigned seed = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error;
  Image<double> blobs(camera.width / 4 + 1, camera.height / 4 + 1);
  for (double& blob : blobs.pixels()) blob = seed ? 0.5 * error(random) : 0;
  Image<float> depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d way = world_from_camera.rotation * unproject(camera, Eigen::Vector2d(x, y), 1);
      double nearest = 1e9;
      for (const Box& box : boxes) {
        const double z = meet(box, world_from_camera.translation, way);
        if (z > 0) nearest = std::min(nearest, z);
      }
      if (nearest < 5)
        depth(x, y) = static_cast<float>(nearest + kKinectV1Noise.step_m(nearest) * blobs(x / 4, y / 4));
    }
  }
  return depth;
}

inline Rigid3 look_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = Eigen::Vector3d(0, 1, 0).cross(z).normalized();
  Rigid3 pose;
  pose.rotation.col(0) = x;
  pose.rotation.col(1) = z.cross(x);
  pose.rotation.col(2) = z;
  pose.translation = eye;
  return pose;
}

/// A room with a table-like box and a smaller one on it. The floor is at y = 0, down is +y.
inline std::vector<Box> furnished_room() {
  return {{{-2, -2.4, -1.5}, {2, 0, 2.5}},
          {{-0.5, -0.7, 0.6}, {0.6, 0, 1.4}},
          {{-0.2, -1.0, 0.8}, {0.1, -0.7, 1.0}},
          {{0.9, -1.1, 1.5}, {1.3, 0, 1.9}}};
}

/// `pose` shifted by `shift` metres and turned by `degrees` about an axis, both in the world.
inline Rigid3 disturbed(const Rigid3& pose, const Eigen::Vector3d& shift, const Eigen::Vector3d& axis,
                        double degrees) {
  return {Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()).toRotationMatrix() * pose.rotation,
          pose.translation + shift};
}

inline double millimetres_between(const Rigid3& a, const Rigid3& b) {
  return 1000 * (a.translation - b.translation).norm();
}

inline double degrees_between(const Rigid3& a, const Rigid3& b) {
  return Eigen::AngleAxisd(a.rotation.transpose() * b.rotation).angle() * 180 / M_PI;
}

}  // namespace copresence::calibrate::test
