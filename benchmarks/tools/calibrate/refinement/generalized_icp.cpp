#include "benchmarks/tools/calibrate/refinement/generalized_icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace copresence::calibrate {
namespace {

constexpr double kEpsilon = 1e-3;
constexpr double kStill = 1e-5;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

std::uint64_t cube_of(const Eigen::Vector3d& point, double cube_m) {
  const auto number = [&](double x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / cube_m)) + (1 << 20)) &
           0x1fffff;
  };
  return number(point.x()) << 42 | number(point.y()) << 21 | number(point.z());
}

// Finds nearest neighbours by a k-d tree, which splits along the axis of largest extent.
class Neighbours {
 public:
  explicit Neighbours(const std::vector<Eigen::Vector3d>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    axes_.resize(points.size());
    halve(0, order_.size());
  }

  /// Returns the index of the nearest point within `reach_m`, or -1 if there is none.
  std::ptrdiff_t nearest(const Eigen::Vector3d& to, double reach_m) const {
    Best best{reach_m * reach_m, -1};
    look(0, order_.size(), to, best);
    return best.point;
  }

 private:
  struct Best {
    double square;
    std::ptrdiff_t point;
  };

  void halve(std::size_t first, std::size_t end) {
    if (end - first < 2) return;
    Eigen::Vector3d low = points_[order_[first]], high = low;
    for (std::size_t i = first; i < end; ++i) {
      low = low.cwiseMin(points_[order_[i]]);
      high = high.cwiseMax(points_[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = first + (end - first) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(end),
                     [&](std::size_t i, std::size_t j) { return points_[i][axis] < points_[j][axis]; });
    axes_[middle] = axis;
    halve(first, middle);
    halve(middle + 1, end);
  }

  void look(std::size_t first, std::size_t end, const Eigen::Vector3d& to, Best& best) const {
    if (first == end) return;
    const std::size_t middle = first + (end - first) / 2;
    const Eigen::Vector3d& point = points_[order_[middle]];
    const double square = (point - to).squaredNorm();
    if (square < best.square) best = {square, static_cast<std::ptrdiff_t>(order_[middle])};
    const double beyond = to[axes_[middle]] - point[axes_[middle]];
    const bool low = beyond < 0;
    look(low ? first : middle + 1, low ? middle : end, to, best);
    if (beyond * beyond < best.square) look(low ? middle + 1 : first, low ? end : middle, to, best);
  }

  const std::vector<Eigen::Vector3d>& points_;
  std::vector<std::size_t> order_;
  std::vector<int> axes_;
};

// Returns the covariance of a point: variance 1 within its plane, and epsilon along the normal.
Eigen::Matrix3d covariance_of(const Eigen::Vector3d& normal) {
  return Eigen::Matrix3d::Identity() - (1 - kEpsilon) * normal * normal.transpose();
}

}  // namespace

Cloud make_cloud(const Surface& surface, double cube_m) {
  struct Sum {
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    int count = 0;
  };
  std::unordered_map<std::uint64_t, Sum> cubes;
  for (std::size_t i = 0; i < surface.sigma.pixels().size(); ++i) {
    if (surface.sigma.data()[i] == 0) continue;
    const Eigen::Vector3d point = surface.point.data()[i].cast<double>();
    Sum& sum = cubes[cube_of(point, cube_m)];
    sum.point += point;
    sum.normal += surface.normal.data()[i].cast<double>();
    ++sum.count;
  }
  Cloud cloud;
  for (const auto& [cube, sum] : cubes) {
    cloud.points.push_back(sum.point / sum.count);
    cloud.normals.push_back(sum.normal.normalized());
  }
  return cloud;
}

Rigid3 generalized_icp(const Cloud& source, const Cloud& target, const Rigid3& start, double reach_m,
                       int iterations) {
  const Neighbours neighbours(target.points);
  Rigid3 pose = start;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Matrix6 A = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (std::size_t i = 0; i < source.points.size(); ++i) {
      const Eigen::Vector3d point = pose * source.points[i];
      const std::ptrdiff_t other = neighbours.nearest(point, reach_m);
      if (other < 0) continue;
      const auto j = static_cast<std::size_t>(other);
      const Eigen::Matrix3d information =
          (covariance_of(target.normals[j]) + covariance_of(pose.rotation * source.normals[i])).inverse();
      Eigen::Matrix<double, 3, 6> J;
      J << 0, point.z(), -point.y(), 1, 0, 0, -point.z(), 0, point.x(), 0, 1, 0, point.y(), -point.x(), 0, 0,
          0, 1;
      A += J.transpose() * information * J;
      g += J.transpose() * information * (point - target.points[j]);
    }
    const Vector6 step = -A.ldlt().solve(g);
    if (!step.allFinite()) return pose;
    const double angle = step.head<3>().norm();
    const Eigen::Matrix3d turn = angle > 0
                                     ? Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix()
                                     : Eigen::Matrix3d::Identity();
    pose = Rigid3{turn, step.tail<3>()} * pose;
    if (step.cwiseAbs().maxCoeff() < kStill) break;
  }
  return pose;
}

}  // namespace copresence::calibrate
