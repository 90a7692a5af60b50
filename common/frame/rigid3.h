#pragma once

// Rigid transforms. `b_from_a` maps a point of frame a to frame b, so neighbouring frame names in a
// product match:
//   Rigid3 left_from_right = left_from_world * world_from_right;
// Camera frames have x right, y down, z forward. Lengths are in metres.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace copresence {

struct Rigid3 {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  Rigid3 inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }

  Eigen::Matrix4d matrix() const {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = rotation;
    m.topRightCorner<3, 1>() = translation;
    return m;
  }

  /// True if all numbers are finite and the rotation is orthonormal and right-handed to
  /// `tolerance`.
  bool is_rigid(double tolerance = 1e-4) const {
    return rotation.allFinite() && translation.allFinite() &&
           (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <=
               tolerance &&
           rotation.determinant() > 0;
  }

  friend bool operator==(const Rigid3& a, const Rigid3& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

}  // namespace copresence
