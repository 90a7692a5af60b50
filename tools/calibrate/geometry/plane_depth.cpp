#include "tools/calibrate/geometry/plane_depth.h"

#include <algorithm>
#include <cassert>
#include <random>
#include <string>

namespace copresence::calibrate {
namespace {

constexpr double kStep = kKinectV1Noise.inverse_step();  // One disparity step of 1/z, in 1/m.
// Largest distance of a pixel from its plane. A mean over frames has less noise than one step, but
// a Kinect's fixed error pattern remains.
constexpr double kOnPlane = 1.5 * kStep;

struct Sample {
  Eigen::Vector3d ray;  // Ray (x, y, 1).
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

// Least squares over the samples that lie on `plane`. Returns their number. `squares` receives the
// sum of their squared errors before the fit.
int refit(std::span<const Sample> samples, Eigen::Vector3d& plane, double& squares) {
  PlaneLeastSquares<double> sums;
  // Rays are relative to the first ray. In a small outline all rays are nearly equal, so absolute
  // rays would lose precision.
  const Eigen::Vector3d origin = samples.front().ray;
  squares = 0;
  for (const Sample& sample : samples) {
    const double error = plane.dot(sample.ray) - sample.inverse_z;
    if (std::abs(error) > kOnPlane) continue;
    sums.add(sample.ray.x() - origin.x(), sample.ray.y() - origin.y(), sample.inverse_z);
    squares += error * error;
  }
  Eigen::Vector3d fitted;
  if (sums.solve(0, fitted)) {
    plane = {fitted.x(), fitted.y(), fitted.z() - fitted.x() * origin.x() - fitted.y() * origin.y()};
  }
  return static_cast<int>(sums.count());
}

}  // namespace

void DepthAverage::add(const DepthImage& depth) {
  if (frames_ == 0) {
    inverse_sum_ = Image<float>(depth.width(), depth.height());
    counts_ = Image<Counts>(depth.width(), depth.height());
  }
  assert(same_shape(depth, inverse_sum_) && frames_ < kMostFrames);
  ++frames_;
  const double metres = metres_per_unit(unit_);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    if (depth.data()[i] == 0) continue;
    const double inverse_z = 1 / (depth.data()[i] * metres);
    float& sum = inverse_sum_.data()[i];
    Counts& counts = counts_.data()[i];
    ++counts.measured;
    const bool agrees =
        counts.agreeing == 0 || std::abs(inverse_z - sum / counts.agreeing) <= kSameSurface_steps * kStep;
    if (agrees) {
      sum += static_cast<float>(inverse_z);
      ++counts.agreeing;
    } else if (++counts.against >= counts.agreeing) {
      sum = static_cast<float>(inverse_z);
      counts.agreeing = 1;
      counts.against = 0;
    }
  }
}

double DepthAverage::inverse_depth(int x, int y) const {
  const int agreeing = counts_(x, y).agreeing;
  return agreeing > 0 && 4 * agreeing >= frames_ ? static_cast<double>(inverse_sum_(x, y)) / agreeing : 0;
}

Image<float> DepthAverage::still_depth() const {
  Image<float> depth(width(), height());
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    const Counts& counts = counts_.data()[i];
    if (!is_measured(counts) || !is_still(counts)) continue;
    depth.data()[i] = static_cast<float>(counts.agreeing) / inverse_sum_.data()[i];
  }
  return depth;
}

double DepthAverage::measured_share() const {
  double measured = 0;
  for (const Counts& counts : counts_.pixels()) measured += counts.measured;
  return frames_ > 0 ? measured / (static_cast<double>(counts_.pixels().size()) * frames_) : 0;
}

double DepthAverage::unsteady_share() const {
  int measured = 0, unsteady = 0;
  for (const Counts& counts : counts_.pixels()) {
    if (!is_measured(counts)) continue;
    ++measured;
    unsteady += !is_still(counts);
  }
  return measured > 0 ? static_cast<double>(unsteady) / measured : 0;
}

Result<PlaneFit> fit_plane(const DepthAverage& depth, const CameraModel& model,
                           std::span<const Eigen::Vector2d> outline) {
  assert(outline.size() >= 3);
  const std::vector<Sample> samples = samples_in(depth, model, outline);
  const int total = static_cast<int>(samples.size());
  if (total < kFewestPixels) {
    return fail(ErrorCode::kNotFound, "only " + std::to_string(total) +
                                          " of its pixels have depth; at least " +
                                          std::to_string(kFewestPixels) + " are needed");
  }
  // A constant seed, so that the same samples always give the same plane.
  std::minstd_rand random(1);
  std::uniform_int_distribution<std::size_t> any(0, samples.size() - 1);
  // If half of the samples are wrong, one draw of three samples in eight has only good ones.
  constexpr int kDraws = 60;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  int most = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Sample &p = samples[any(random)], &q = samples[any(random)], &r = samples[any(random)];
    Eigen::Matrix3d rays;
    rays << p.ray.transpose(), q.ray.transpose(), r.ray.transpose();
    if (std::abs(rays.determinant()) < 1e-6) continue;  // The pixels are nearly on one line.
    const Eigen::Vector3d plane = rays.inverse() * Eigen::Vector3d(p.inverse_z, q.inverse_z, r.inverse_z);
    const auto on_plane =
        static_cast<int>(std::count_if(samples.begin(), samples.end(), [&](const Sample& s) {
          return std::abs(plane.dot(s.ray) - s.inverse_z) <= kOnPlane;
        }));
    if (on_plane > most) {
      most = on_plane;
      best = plane;
    }
  }
  double squares = 0;
  for (int round = 0; round < 4; ++round) most = refit(samples, best, squares);
  if (2 * most < total) {
    return fail(ErrorCode::kNotFound, "its depth is no plane: only " + std::to_string(100 * most / total) +
                                          " % of its pixels lie on one");
  }
  PlaneFit fit;
  fit.slope = best.head<2>();
  fit.offset = best.z();
  fit.pixels = most;
  fit.share = static_cast<double>(most) / total;
  fit.rms_steps = std::sqrt(squares / most) / kStep;
  return fit;
}

}  // namespace copresence::calibrate
