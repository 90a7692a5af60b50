#include "tools/calibrate/geometry/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>

#include "tools/calibrate/geometry/rigid_fit.h"

namespace copresence::calibrate {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

constexpr double kHuber = 2.5;     // Residuals beyond this many sigmas get less weight.
constexpr double kNearest = 0.01;  // Minimum depth of a point while the solver searches, metres.

// `step` is a rotation vector, then a translation, both in the camera's own frame.
Rigid3 moved(const Rigid3& pose, const Vector6& step) {
  return {orthonormal(pose.rotation * rotation_from_vector(step.head<3>())),
          pose.rotation * step.tail<3>() + pose.translation};
}

// The three errors of one observation, in sigmas, and their derivatives by pose and by point.
struct Linearized {
  Eigen::Vector3d error;
  Matrix36 by_pose;
  Eigen::Matrix3d by_point;
};

Linearized linearize(const Observation& observation, const Rigid3& world_from_camera,
                     const Eigen::Vector3d& in_world) {
  Eigen::Vector3d p = world_from_camera.inverse() * in_world;
  p.z() = std::max(p.z(), kNearest);
  const double inverse = 1 / p.z(), by_ray = 1 / observation.ray_sigma;
  const double by_depth = std::isfinite(observation.inverse_z_sigma) ? 1 / observation.inverse_z_sigma : 0;
  Linearized out;
  out.error << (p.x() * inverse - observation.ray.x()) * by_ray,
      (p.y() * inverse - observation.ray.y()) * by_ray, (inverse - 1 / observation.z_m) * by_depth;
  Eigen::Matrix3d by_camera_point;
  by_camera_point << inverse * by_ray, 0, -p.x() * inverse * inverse * by_ray,  //
      0, inverse * by_ray, -p.y() * inverse * inverse * by_ray,                 //
      0, 0, -inverse * inverse * by_depth;
  out.by_pose.leftCols<3>() = by_camera_point * cross_matrix(p);
  out.by_pose.rightCols<3>() = -by_camera_point;
  out.by_point = by_camera_point * world_from_camera.rotation.transpose();
  return out;
}

// Rays and depth have separate weights: a ray keeps its weight if the depth is an outlier.
Eigen::Vector3d huber_weights(const Eigen::Vector3d& error) {
  const double ray = error.head<2>().norm(), depth = std::abs(error.z());
  const double of_ray = ray > kHuber ? kHuber / ray : 1;
  return {of_ray, of_ray, depth > kHuber ? kHuber / depth : 1};
}

double robust_cost(const Eigen::Vector3d& error) {
  const auto cost = [](double e) { return e <= kHuber ? e * e : 2 * kHuber * e - kHuber * kHuber; };
  return cost(error.head<2>().norm()) + cost(std::abs(error.z()));
}

class Adjustment {
 public:
  Adjustment(std::span<const Observation> observations, std::span<const Rigid3> start, std::size_t reference)
      : sightings_(observations), poses_(start.begin(), start.end()), reference_(reference) {
    std::map<std::pair<std::size_t, int>, std::size_t> numbers;
    std::vector<double> weights;
    for (const Observation& observation : observations) {
      assert(observation.camera < start.size() && observation.z_m > 0);
      const auto [entry, is_new] =
          numbers.try_emplace({observation.marker, observation.part}, points_.size());
      if (is_new) {
        points_.push_back(Eigen::Vector3d::Zero());
        weights.push_back(0);
        seen_.emplace_back();
        if (observation.part == 0) middles_[observation.marker] = entry->second;
      }
      // If a depth is unknown, its value is a first guess. The guess gets the weight of a sensor's
      // depth.
      const double weight = 1 / (std::pow(observation.z_m, 4));
      points_[entry->second] += weight * (poses_[observation.camera] * observation.point_in_camera());
      weights[entry->second] += weight;
      seen_[entry->second].push_back(&observation);
    }
    for (std::size_t i = 0; i < points_.size(); ++i) points_[i] /= weights[i];
  }

  double cost(const std::vector<Rigid3>& poses, const std::vector<Eigen::Vector3d>& points) const {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const Observation* observation : seen_[i]) {
        sum += robust_cost(linearize(*observation, poses[observation->camera], points[i]).error);
      }
    }
    return sum;
  }

  /// Builds the cameras' normal equations. The points are eliminated, and `lambda` damps them.
  void reduce(double lambda) {
    const auto size = static_cast<Eigen::Index>(6 * poses_.size());
    normal_ = Eigen::MatrixXd::Zero(size, size);
    right_ = Eigen::VectorXd::Zero(size);
    shares_.assign(points_.size(), {});
    for (std::size_t i = 0; i < points_.size(); ++i) {
      PointShare& share = shares_[i];
      for (const Observation* observation : seen_[i]) {
        const Linearized l = linearize(*observation, poses_[observation->camera], points_[i]);
        const Eigen::Vector3d weight = huber_weights(l.error);
        share.normal += l.by_point.transpose() * weight.asDiagonal() * l.by_point;
        share.right -= l.by_point.transpose() * weight.asDiagonal() * l.error;
        share.with_pose.push_back(l.by_pose.transpose() * weight.asDiagonal() * l.by_point);
        const Eigen::Index at = row(observation->camera);
        normal_.block<6, 6>(at, at) += l.by_pose.transpose() * weight.asDiagonal() * l.by_pose;
        right_.segment<6>(at) -= l.by_pose.transpose() * weight.asDiagonal() * l.error;
      }
    }
    normal_.diagonal() *= 1 + lambda;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      PointShare& share = shares_[i];
      // A point that one camera sees without depth can move freely along its ray. The prior of 1 m
      // fixes the point and is weaker than any observation.
      share.normal.diagonal() = share.normal.diagonal() * (1 + lambda) + Eigen::Vector3d::Ones();
      share.inverse = share.normal.inverse();
      for (std::size_t a = 0; a < seen_[i].size(); ++a) {
        const Eigen::Matrix<double, 6, 3> eliminated = share.with_pose[a] * share.inverse;
        const Eigen::Index at = row(seen_[i][a]->camera);
        right_.segment<6>(at) -= eliminated * share.right;
        for (std::size_t b = 0; b < seen_[i].size(); ++b) {
          normal_.block<6, 6>(at, row(seen_[i][b]->camera)) -= eliminated * share.with_pose[b].transpose();
        }
      }
    }
    // The reference camera keeps its pose.
    const Eigen::Index fixed = row(reference_);
    normal_.middleRows<6>(fixed).setZero();
    normal_.middleCols<6>(fixed).setZero();
    normal_.block<6, 6>(fixed, fixed).setIdentity();
    right_.segment<6>(fixed).setZero();
  }

  void solve() {
    double lambda = 1e-6, before = cost(poses_, points_);
    for (int iteration = 0; iteration < 60 && lambda < 1e8; ++iteration) {
      reduce(lambda);
      const Eigen::VectorXd step = normal_.ldlt().solve(right_);
      std::vector<Rigid3> poses = poses_;
      std::vector<Eigen::Vector3d> points = points_;
      for (std::size_t c = 0; c < poses.size(); ++c) {
        if (c != reference_) poses[c] = moved(poses[c], step.segment<6>(row(c)));
      }
      for (std::size_t i = 0; i < points.size(); ++i) {
        Eigen::Vector3d right = shares_[i].right;
        for (std::size_t a = 0; a < seen_[i].size(); ++a) {
          right -= shares_[i].with_pose[a].transpose() * step.segment<6>(row(seen_[i][a]->camera));
        }
        points[i] += shares_[i].inverse * right;
      }
      const double after = cost(poses, points);
      if (!(after <= before)) {
        lambda = std::max(lambda, 1e-6) * 10;
        continue;
      }
      poses_ = std::move(poses);
      points_ = std::move(points);
      lambda /= 10;
      if (before - after <= 1e-9 * (1 + before)) break;
      before = after;
    }
  }

  BundleAdjustment result(std::size_t markers) {
    BundleAdjustment fit;
    fit.world_from_camera = poses_;
    fit.marker_in_world.assign(markers, Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (const auto& [marker, point] : middles_) fit.marker_in_world[marker] = points_[point];
    reduce(0);
    const Eigen::Index size = normal_.rows(), fixed = row(reference_);
    fit.covariance = normal_.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
    fit.covariance.block<6, 6>(fixed, fixed).setZero();
    // Degrees of freedom: 2 or 3 residuals per observation, less 6 per pose and 3 per point. A
    // point that only one observation shows adds no more unknowns than residuals.
    double residuals = 0, unknowns = 6.0 * static_cast<double>(poses_.size() - 1);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      double here = 0;
      for (const Observation* s : seen_[i]) here += std::isfinite(s->inverse_z_sigma) ? 3 : 2;
      residuals += here;
      unknowns += std::min(here, 3.0);
    }
    // A few observations may fit well by chance, which does not prove that the noise is small.
    constexpr double kLeastRatio = 0.5;
    fit.noise_ratio = residuals > unknowns
                          ? std::max(kLeastRatio, std::sqrt(cost(poses_, points_) / (residuals - unknowns)))
                          : 1;
    return fit;
  }

 private:
  struct PointShare {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), inverse;
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::vector<Eigen::Matrix<double, 6, 3>> with_pose;
  };

  static Eigen::Index row(std::size_t camera) { return static_cast<Eigen::Index>(6 * camera); }

  std::span<const Observation> sightings_;
  std::vector<Rigid3> poses_;
  std::size_t reference_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::vector<const Observation*>> seen_;
  std::map<std::size_t, std::size_t> middles_;  // Point index of each marker's centre.
  Eigen::MatrixXd normal_;
  Eigen::VectorXd right_;
  std::vector<PointShare> shares_;
};

}  // namespace

double BundleAdjustment::expected_shift_m(std::size_t camera, const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d p = world_from_camera[camera].inverse() * point_in_world;
  Matrix36 by_pose;
  by_pose << -cross_matrix(p), Eigen::Matrix3d::Identity();
  const auto at = static_cast<Eigen::Index>(6 * camera);
  return noise_ratio * std::sqrt((by_pose * covariance.block<6, 6>(at, at) * by_pose.transpose()).trace());
}

double BundleAdjustment::expected_turn(std::size_t camera) const {
  const auto at = static_cast<Eigen::Index>(6 * camera);
  return noise_ratio * std::sqrt(covariance.block<3, 3>(at, at).trace());
}

BundleAdjustment adjust_bundle(std::span<const Observation> observations, std::span<const Rigid3> start,
                               std::size_t reference) {
  assert(reference < start.size());
  std::size_t markers = 0;
  for (const Observation& observation : observations) markers = std::max(markers, observation.marker + 1);
  Adjustment adjustment(observations, start, reference);
  adjustment.solve();
  return adjustment.result(markers);
}

}  // namespace copresence::calibrate
