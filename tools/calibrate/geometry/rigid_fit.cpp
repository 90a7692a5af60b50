#include "tools/calibrate/geometry/rigid_fit.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cassert>
#include <cmath>
#include <vector>

namespace copresence::calibrate {
namespace {

struct Centroids {
  Eigen::Vector3d in_a = Eigen::Vector3d::Zero(), in_b = Eigen::Vector3d::Zero();
};

Centroids centroids_of(std::span<const PointPair> pairs) {
  Centroids sum;
  double weight = 0;
  for (const PointPair& pair : pairs) {
    sum.in_a += pair.weight * pair.in_a;
    sum.in_b += pair.weight * pair.in_b;
    weight += pair.weight;
  }
  return {sum.in_a / weight, sum.in_b / weight};
}

// The rotation nearest to m, never a reflection: U diag(1, 1, det) V^T by the SVD of m.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Rigid3 fit_rigid(std::span<const PointPair> pairs) {
  assert(pairs.size() >= 3);
  const Centroids centroids = centroids_of(pairs);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    covariance += pair.weight * (pair.in_b - centroids.in_b) * (pair.in_a - centroids.in_a).transpose();
  }
  const Eigen::Matrix3d rotation = nearest_rotation(covariance);
  return {rotation, centroids.in_b - rotation * centroids.in_a};
}

LinearFit fit_linear(std::span<const PointPair> pairs) {
  assert(pairs.size() >= 4);
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixX4d points(count, 4);
  Eigen::MatrixX3d images(count, 3);
  std::vector<PointPair> unweighted(pairs.begin(), pairs.end());
  for (Eigen::Index i = 0; i < count; ++i) {
    PointPair& pair = unweighted[static_cast<std::size_t>(i)];
    pair.weight = 1;
    points.row(i) << pair.in_a.transpose(), 1;
    images.row(i) = pair.in_b.transpose();
  }
  LinearFit fit;
  fit.b_from_a = points.colPivHouseholderQr().solve(images).transpose();
  const Eigen::Matrix3d linear = fit.b_from_a.leftCols<3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear);
  fit.most_scale = svd.singularValues()(0);
  fit.least_scale = svd.singularValues()(2);
  const Centroids centroids = centroids_of(unweighted);
  fit.rigid.rotation = nearest_rotation(linear);
  fit.rigid.translation = centroids.in_b - fit.rigid.rotation * centroids.in_a;
  return fit;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, v / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& rotation) {
  return Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
}

double rms_distance(const Rigid3& b_from_a, std::span<const PointPair> pairs) {
  assert(!pairs.empty());
  double sum = 0;
  for (const PointPair& pair : pairs) sum += (b_from_a * pair.in_a - pair.in_b).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

}  // namespace copresence::calibrate
