#include "tools/calibrate/alignment/agreement.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace copresence::alignment {
namespace {

constexpr double kLeastCosine = 0.7;

struct Tally {
  std::vector<double> distances, sigmas;
  double weights = 0, squares = 0, support = 0;
  int contradictions = 0, looked_at = 0;
};

struct Look {
  Meeting meeting = Meeting::kUnseen;
  double distance = 0, sigma = 0;  // metres
};

// A point of a, in b's frame, in b's picture.
Look look(const Surface& a, int x, int y, const Surface& b, const Rigid3& b_from_a, bool distorted) {
  if (a.sigma(x, y) == 0) return {Meeting::kNone};
  const Eigen::Vector3d point = b_from_a * a.point(x, y).cast<double>();
  if (point.z() < 0.1) return {};
  if (distorted && point.head<2>().squaredNorm() > 4 * point.z() * point.z()) return {};
  const Eigen::Vector2d pixel = project(b.model, point);
  if (!(pixel.x() > -0.5 && pixel.x() < b.model.width - 0.5 && pixel.y() > -0.5 &&
        pixel.y() < b.model.height - 0.5)) {
    return {};
  }
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (b.depth_m(u, v) == 0) return {};
  const double sigma = std::hypot(a.sigma(x, y), b.sigma(u, v));
  if (b.sigma(u, v) > 0) {
    const Eigen::Vector3d normal_a = b_from_a.rotation * a.normal(x, y).cast<double>();
    const Eigen::Vector3d normal_b = b.normal(u, v).cast<double>();
    if (normal_a.dot(normal_b) > kLeastCosine) {
      const double distance = (normal_a + normal_b).normalized().dot(point - b.point(u, v).cast<double>());
      if (std::abs(distance) < kSameSurface_m) return {Meeting::kMeets, distance, sigma};
    }
  }
  // Beside an edge a pixel decides between two surfaces, so only what the whole neighbourhood lies behind counts.
  for (int dv = -2; dv <= 2; dv += 2) {
    for (int du = -2; du <= 2; du += 2) {
      const int nu = std::clamp(u + du, 0, b.model.width - 1), nv = std::clamp(v + dv, 0, b.model.height - 1);
      if (b.depth_m(nu, nv) <= point.z() + kSameSurface_m + 3 * sigma) return {};
    }
  }
  return {Meeting::kContradicts, 0, sigma};
}

// One way: points of a in b's picture. Returns how many meet.
int look_at_all(const Surface& a, const Surface& b, const Rigid3& b_from_a, int spacing, Tally& tally) {
  const bool distorted = b.model.is_distorted();
  int meetings = 0;
  for (int y = spacing / 2; y < a.model.height; y += spacing) {
    for (int x = spacing / 2; x < a.model.width; x += spacing) {
      const Look seen = look(a, x, y, b, b_from_a, distorted);
      tally.looked_at += seen.meeting != Meeting::kNone;
      if (seen.meeting == Meeting::kMeets) {
        const double share = seen.distance / kSameSurface_m, weight = weight_of(seen.sigma);
        ++meetings;
        tally.distances.push_back(std::abs(seen.distance));
        tally.sigmas.push_back(std::abs(seen.distance) / seen.sigma);
        tally.weights += weight;
        tally.squares += weight * seen.distance * seen.distance;
        tally.support += 1 - share * share;
      } else if (seen.meeting == Meeting::kContradicts) {
        const double weight = weight_of(seen.sigma);
        ++tally.contradictions;
        tally.weights += weight;
        tally.squares += weight * kSameSurface_m * kSameSurface_m;
        tally.support -= 1;
      }
    }
  }
  return meetings;
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

double weight_of(double sigma_m) {
  constexpr double kFloor_m = 0.003;
  return 1 / std::hypot(sigma_m, kFloor_m);
}

Meetings find_meetings(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                       const Rigid3& world_from_b) {
  const Rigid3 b_from_a = world_from_b.inverse() * world_from_a;
  const bool distorted = b.model.is_distorted();
  Meetings found{Image<Meeting>(a.model.width, a.model.height), Image<float>(a.model.width, a.model.height)};
  for (int y = 0; y < a.model.height; ++y) {
    for (int x = 0; x < a.model.width; ++x) {
      const Look seen = look(a, x, y, b, b_from_a, distorted);
      found.meeting(x, y) = seen.meeting;
      found.distance_m(x, y) = static_cast<float>(seen.distance);
    }
  }
  return found;
}

Agreement measure_agreement(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                            const Rigid3& world_from_b, int spacing) {
  const Rigid3 b_from_a = world_from_b.inverse() * world_from_a;
  Tally tally;
  Agreement agreement;
  const int one_way = look_at_all(a, b, b_from_a, spacing, tally);
  const int points_of_a = tally.looked_at;
  const int other_way = look_at_all(b, a, b_from_a.inverse(), spacing, tally);
  const int points_of_b = tally.looked_at - points_of_a;
  agreement.overlap =
      std::max(one_way / std::max(1.0, 1.0 * points_of_a), other_way / std::max(1.0, 1.0 * points_of_b));
  agreement.points = static_cast<int>(tally.distances.size());
  if (agreement.points + tally.contradictions > 0) {
    agreement.contradicted =
        static_cast<double>(tally.contradictions) / (agreement.points + tally.contradictions);
    agreement.rms_m = std::sqrt(tally.squares / tally.weights);
  }
  agreement.support = tally.looked_at ? tally.support / tally.looked_at : 0;
  agreement.median_m = quantile(tally.distances, 0.5);
  agreement.p95_m = quantile(tally.distances, 0.95);
  agreement.median_sigmas = quantile(tally.sigmas, 0.5);
  agreement.p95_sigmas = quantile(tally.sigmas, 0.95);
  return agreement;
}

}  // namespace copresence::alignment
