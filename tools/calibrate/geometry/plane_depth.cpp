#include "tools/calibrate/geometry/plane_depth.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

namespace copresence::calibration {
namespace {

constexpr double kStep = kKinectV1Noise.inverse_step();  // 1/m
// Two levels for a single frame's pixel; a mean of many errs less, but a Kinect's fixed pattern stays.
constexpr double kAgrees = 1.5 * kStep;
constexpr double kSameSurface = 4 * kStep;

struct Sample {
  Eigen::Vector3d ray;  // (x, y, 1)
  double inverse_z;
};

bool is_inside(std::span<const Eigen::Vector2d> outline, double x, double y) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i], ab = outline[(i + 1) % outline.size()] - a;
    const double side = ab.x() * (y - a.y()) - ab.y() * (x - a.x());
    (side >= 0 ? left : right) += 1;
  }
  return left == 0 || right == 0;
}

std::vector<Sample> samples_in(const DepthAverage& depth, const CameraModel& model,
                               std::span<const Eigen::Vector2d> outline) {
  Eigen::Vector2d low = outline[0], high = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  std::vector<Sample> samples;
  for (int y = std::max(0, int(std::ceil(low.y()))); y <= std::min(depth.height() - 1.0, high.y()); ++y) {
    for (int x = std::max(0, int(std::ceil(low.x()))); x <= std::min(depth.width() - 1.0, high.x()); ++x) {
      const double inverse_z = depth.inverse_depth(x, y);
      if (inverse_z > 0 && is_inside(outline, x, y)) {
        samples.push_back({unproject(model, {double(x), double(y)}, 1), inverse_z});
      }
    }
  }
  return samples;
}

// Least squares over those that agree with `plane`; the sum of squares goes to `squares`.
int refit(std::span<const Sample> samples, Eigen::Vector3d& plane, double& squares) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  int count = 0;
  squares = 0;
  for (const Sample& sample : samples) {
    const double error = plane.dot(sample.ray) - sample.inverse_z;
    if (std::abs(error) > kAgrees) continue;
    a += sample.ray * sample.ray.transpose();
    b += sample.ray * sample.inverse_z;
    squares += error * error;
    ++count;
  }
  if (count >= 3) plane = a.ldlt().solve(b);
  return count;
}

}  // namespace

void DepthAverage::add(const DepthImage& depth) {
  if (frames_ == 0) {
    inverse_sum_ = Image<float>(depth.width(), depth.height());
    count_ = Image<std::uint16_t>(depth.width(), depth.height());
  }
  assert(same_shape(depth, inverse_sum_) && frames_ < 65535);
  ++frames_;
  const double metres = metres_per_unit(unit_);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    if (depth.data()[i] == 0) continue;
    const double inverse_z = 1 / (depth.data()[i] * metres);
    float& sum = inverse_sum_.data()[i];
    std::uint16_t& count = count_.data()[i];
    if (count > 0 && std::abs(inverse_z - sum / count) > kSameSurface) continue;
    sum += static_cast<float>(inverse_z);
    ++count;
  }
}

double DepthAverage::inverse_depth(int x, int y) const {
  const int count = count_(x, y);
  return count > 0 && 4 * count >= frames_ ? static_cast<double>(inverse_sum_(x, y)) / count : 0;
}

Result<PlaneFit> fit_plane(const DepthAverage& depth, const CameraModel& model,
                           std::span<const Eigen::Vector2d> outline) {
  assert(outline.size() >= 3);
  const std::vector<Sample> samples = samples_in(depth, model, outline);
  const int total = static_cast<int>(samples.size());
  if (total < kFewestPixels) {
    return fail(ErrorCode::kNotFound, "only " + std::to_string(total) +
                                          " of its pixels have depth, of at least " +
                                          std::to_string(kFewestPixels) + " needed");
  }
  // A random search for the plane on which most agree; the same samples give the same plane.
  std::minstd_rand random(1);
  std::uniform_int_distribution<std::size_t> any(0, samples.size() - 1);
  constexpr int kDraws = 60;  // with half of the samples astray, one in eight draws is good
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  int most = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Sample &p = samples[any(random)], &q = samples[any(random)], &r = samples[any(random)];
    Eigen::Matrix3d rays;
    rays << p.ray.transpose(), q.ray.transpose(), r.ray.transpose();
    if (std::abs(rays.determinant()) < 1e-6) continue;  // nearly on one line of the picture
    const Eigen::Vector3d plane = rays.inverse() * Eigen::Vector3d(p.inverse_z, q.inverse_z, r.inverse_z);
    const auto agreeing =
        static_cast<int>(std::count_if(samples.begin(), samples.end(), [&](const Sample& s) {
          return std::abs(plane.dot(s.ray) - s.inverse_z) <= kAgrees;
        }));
    if (agreeing > most) {
      most = agreeing;
      best = plane;
    }
  }
  double squares = 0;
  for (int round = 0; round < 4; ++round) most = refit(samples, best, squares);
  if (2 * most < total) {
    return fail(ErrorCode::kNotFound, "its depth is no plane: only " + std::to_string(100 * most / total) +
                                          " % of its pixels agree on one");
  }
  PlaneFit fit;
  fit.slope = best.head<2>();
  fit.offset = best.z();
  fit.pixels = most;
  fit.share = static_cast<double>(most) / total;
  fit.rms_steps = std::sqrt(squares / most) / kStep;
  return fit;
}

}  // namespace copresence::calibration
