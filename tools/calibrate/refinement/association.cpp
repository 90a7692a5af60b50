#include "tools/calibrate/refinement/association.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/calibrate/geometry/quantile.h"

namespace copresence::calibrate {
namespace {

constexpr double kLeastCosine = 0.7;  // Minimum cosine between normals of one surface's points.
constexpr double kNearest_m = 0.1;    // Minimum depth of a point in the other camera's frame.

// Projects the points of surface a into the picture of camera b.
class Projector {
 public:
  Projector(const Surface& a, const Surface& b, const Rigid3& b_from_a)
      : a_(a), b_(b), b_from_a_(b_from_a), is_distorted_(b.model.is_distorted()) {}

  struct Target {
    Eigen::Vector3d point;  // Point of a in b's frame.
    int u = 0, v = 0;       // The pixel of b's picture that shows the point.
  };

  /// Returns nothing if the point is not in b's picture. Requires that surface a has a point there.
  std::optional<Target> project_pixel(int x, int y) const {
    Target target{b_from_a_ * a_.point(x, y).cast<double>()};
    const Eigen::Vector3d& p = target.point;
    if (p.z() < kNearest_m) return std::nullopt;
    // A distortion model is meaningless far outside of the picture.
    if (is_distorted_ && p.head<2>().squaredNorm() > 4 * p.z() * p.z()) return std::nullopt;
    const Eigen::Vector2d pixel = project(b_.model, p);
    if (!(pixel.x() > -0.5 && pixel.x() < b_.model.width - 0.5 && pixel.y() > -0.5 &&
          pixel.y() < b_.model.height - 0.5)) {
      return std::nullopt;
    }
    target.u = static_cast<int>(std::lround(pixel.x()));
    target.v = static_cast<int>(std::lround(pixel.y()));
    return target;
  }

  /// Sum of both normals in b's frame. Returns nothing if b has no similar surface there.
  std::optional<Eigen::Vector3d> common_normal(int x, int y, const Target& target) const {
    if (b_.sigma(target.u, target.v) == 0) return std::nullopt;
    const Eigen::Vector3d normal_a = b_from_a_.rotation * a_.normal(x, y).cast<double>();
    const Eigen::Vector3d normal_b = b_.normal(target.u, target.v).cast<double>();
    if (normal_a.dot(normal_b) < kLeastCosine) return std::nullopt;
    return normal_a + normal_b;
  }

  double sigma(int x, int y, const Target& target) const {
    return std::hypot(a_.sigma(x, y), b_.sigma(target.u, target.v));
  }

 private:
  const Surface &a_, &b_;
  Rigid3 b_from_a_;
  bool is_distorted_;
};

struct Comparison {
  Association association = Association::kNotSeen;
  double distance = 0, sigma = 0;  // In metres.
};

Comparison compare(const Surface& a, int x, int y, const Surface& b, const Projector& projector) {
  if (a.sigma(x, y) == 0) return {Association::kNone};
  const auto target = projector.project_pixel(x, y);
  if (!target || b.depth_m(target->u, target->v) == 0) return {};
  const double sigma = projector.sigma(x, y, *target);
  if (const auto normal = projector.common_normal(x, y, *target)) {
    const Eigen::Vector3d other = b.point(target->u, target->v).cast<double>();
    const double distance = normal->normalized().dot(target->point - other);
    if (std::abs(distance) < kSameSurface_m) return {Association::kInlier, distance, sigma};
  }
  // At an edge, one pixel decides between two surfaces. So a violation requires that all pixels
  // around it show surfaces behind the point.
  for (int dv = -2; dv <= 2; dv += 2) {
    for (int du = -2; du <= 2; du += 2) {
      const int u = std::clamp(target->u + du, 0, b.model.width - 1),
                v = std::clamp(target->v + dv, 0, b.model.height - 1);
      if (b.depth_m(u, v) <= target->point.z() + kSameSurface_m + 3 * sigma) return {};
    }
  }
  return {Association::kViolation, 0, sigma};
}

struct Tally {
  std::vector<double> distances, sigmas;
  double weights = 0, squares = 0, score = 0;
  int violations = 0, points = 0;
};

// Compares all points of surface a with surface b and adds the results to `tally`. Returns the
// number of inliers.
int compare_all(const Surface& a, const Surface& b, const Rigid3& b_from_a, int spacing, Tally& tally) {
  const Projector projector(a, b, b_from_a);
  int inliers = 0;
  for (int y = spacing / 2; y < a.model.height; y += spacing) {
    for (int x = spacing / 2; x < a.model.width; x += spacing) {
      const Comparison point = compare(a, x, y, b, projector);
      tally.points += point.association != Association::kNone;
      if (point.association == Association::kInlier) {
        const double share = point.distance / kSameSurface_m, weight = weight_of(point.sigma);
        ++inliers;
        tally.distances.push_back(std::abs(point.distance));
        tally.sigmas.push_back(std::abs(point.distance) / point.sigma);
        tally.weights += weight;
        tally.squares += weight * point.distance * point.distance;
        tally.score += 1 - share * share;
      } else if (point.association == Association::kViolation) {
        const double weight = weight_of(point.sigma);
        ++tally.violations;
        tally.weights += weight;
        tally.squares += weight * kSameSurface_m * kSameSurface_m;
        tally.score -= 1;
      }
    }
  }
  return inliers;
}

}  // namespace

double weight_of(double sigma_m) {
  constexpr double kFloor_m = 0.003;
  return 1 / std::hypot(sigma_m, kFloor_m);
}

void append_matches(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                    const Rigid3& world_from_b, const MatchRules& rules, std::vector<Match>& matches) {
  const Projector projector(a, b, world_from_b.inverse() * world_from_a);
  for (int y = rules.spacing / 2; y < a.model.height; y += rules.spacing) {
    for (int x = rules.spacing / 2; x < a.model.width; x += rules.spacing) {
      if (a.sigma(x, y) == 0) continue;
      const auto target = projector.project_pixel(x, y);
      if (!target) continue;
      const auto normal = projector.common_normal(x, y, *target);
      if (!normal) continue;
      const Eigen::Vector3d other = b.point(target->u, target->v).cast<double>();
      const Eigen::Vector3d other_normal = b.normal(target->u, target->v).cast<double>();
      const double sigma = projector.sigma(x, y, *target);
      if (std::abs(other_normal.dot(target->point - other)) > rules.reach_m + 3 * sigma) continue;
      Match match;
      match.a = world_from_b * target->point;
      match.b = world_from_b * other;
      match.normal = world_from_b.rotation * normal->normalized();
      match.pixel_a = y * a.model.width + x;
      match.pixel_b = target->v * b.model.width + target->u;
      match.sigma = sigma;
      matches.push_back(match);
    }
  }
}

AssociationImage associate(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                           const Rigid3& world_from_b) {
  const Projector projector(a, b, world_from_b.inverse() * world_from_a);
  AssociationImage image{Image<Association>(a.model.width, a.model.height),
                         Image<float>(a.model.width, a.model.height)};
  for (int y = 0; y < a.model.height; ++y) {
    for (int x = 0; x < a.model.width; ++x) {
      const Comparison point = compare(a, x, y, b, projector);
      image.association(x, y) = point.association;
      image.distance_m(x, y) = static_cast<float>(point.distance);
    }
  }
  return image;
}

Agreement measure_agreement(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                            const Rigid3& world_from_b, int spacing) {
  const Rigid3 b_from_a = world_from_b.inverse() * world_from_a;
  Tally tally;
  const int inliers_of_a = compare_all(a, b, b_from_a, spacing, tally);
  const int points_of_a = tally.points;
  const int inliers_of_b = compare_all(b, a, b_from_a.inverse(), spacing, tally);
  const int points_of_b = tally.points - points_of_a;
  Agreement agreement;
  agreement.overlap = std::max(inliers_of_a / std::max(1.0, 1.0 * points_of_a),
                               inliers_of_b / std::max(1.0, 1.0 * points_of_b));
  agreement.points = inliers_of_a + inliers_of_b;
  if (agreement.points + tally.violations > 0) {
    agreement.contradicted = static_cast<double>(tally.violations) / (agreement.points + tally.violations);
    agreement.rms_m = std::sqrt(tally.squares / tally.weights);
  }
  agreement.score = tally.points > 0 ? tally.score / tally.points : 0;
  agreement.median_m = quantile(tally.distances, 0.5);
  agreement.p95_m = quantile(tally.distances, 0.95);
  agreement.median_sigmas = quantile(tally.sigmas, 0.5);
  agreement.p95_sigmas = quantile(tally.sigmas, 0.95);
  return agreement;
}

}  // namespace copresence::calibrate
