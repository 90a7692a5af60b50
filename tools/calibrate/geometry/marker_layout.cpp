#include "tools/calibrate/geometry/marker_layout.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace copresence::calibrate {
namespace {

std::string names_of(std::span<const NamedPoint> points) {
  std::string text;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) text += i + 1 == points.size() ? " and " : ", ";
    text += points[i].name;
  }
  return text;
}

int in_cm(double metres) {
  return static_cast<int>(std::lround(metres * 100));
}

// The two points that are farthest apart, and their distance.
struct Extent {
  std::size_t a = 0, b = 0;
  double distance = 0;
};

Extent extent_of(std::span<const NamedPoint> points) {
  Extent most;
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      const double distance = (points[a].position - points[b].position).norm();
      if (distance > most.distance) most = {a, b, distance};
    }
  }
  return most;
}

// The marker nearest to the centre. Moving this marker sideways improves the layout most, and keeps
// it in view.
const NamedPoint& most_central(std::span<const NamedPoint> points, const Eigen::Vector3d& middle) {
  return *std::min_element(points.begin(), points.end(), [&](const NamedPoint& a, const NamedPoint& b) {
    return (a.position - middle).norm() < (b.position - middle).norm();
  });
}

}  // namespace

Result<void> check_layout(std::span<const NamedPoint> points, Solver solver, const std::string& cameras) {
  if (points.size() < kFewestMarkers) {
    const std::string seen = points.empty() ? "no marker"
                                            : fmt::format("only {} marker{} ({})", points.size(),
                                                          points.size() == 1 ? "" : "s", names_of(points));
    return fail(ErrorCode::kInvalid,
                fmt::format("{} see {} in common, but need {}: put more markers where both see them", cameras,
                            seen, kFewestMarkers));
  }
  const Extent extent = extent_of(points);
  if (extent.distance < kLeastExtent) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the markers that {} see in common ({}) are all within {} cm of each other: move some of "
                    "them apart, until at least {} cm lie between the outermost",
                    cameras, names_of(points), in_cm(extent.distance), in_cm(kLeastExtent)));
  }

  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const NamedPoint& point : points) middle += point.position / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const NamedPoint& point : points) {
    scatter += (point.position - middle) * (point.position - middle).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);  // Eigenvalues in ascending order.
  const Eigen::Vector3d along = axes.eigenvectors().col(2), across = axes.eigenvectors().col(0);
  double off_line = 0, off_plane = 0;
  for (const NamedPoint& point : points) {
    const Eigen::Vector3d d = point.position - middle;
    off_line = std::max(off_line, (d - along * along.dot(d)).norm());
    off_plane = std::max(off_plane, std::abs(across.dot(d)));
  }
  const std::string& central = most_central(points, middle).name;
  if (off_line < kLeastOffLine) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the markers that {} see in common ({}) lie almost on a line, at most {} cm off it: move "
                    "marker {} at least {} cm sideways off the line",
                    cameras, names_of(points), in_cm(off_line), central, in_cm(2 * kLeastOffLine)));
  }
  if (solver == Solver::kLinear && off_plane < kLeastOffPlane) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "the markers that {} see in common ({}) lie almost in one plane, at most {} cm off it, "
            "which the linear solver cannot use: move marker {} at least {} cm towards the cameras, or "
            "use the rigid solver",
            cameras, names_of(points), in_cm(off_plane), central, in_cm(3 * kLeastOffPlane)));
  }
  return {};
}

}  // namespace copresence::calibrate
