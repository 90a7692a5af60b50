#include "tools/calibrate/alignment/matches.h"

#include <cmath>

namespace copresence::alignment {

void append_matches(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                    const Rigid3& world_from_b, const MatchRules& rules, std::vector<Match>& matches) {
  const Rigid3 b_from_a = world_from_b.inverse() * world_from_a;
  const bool distorted = b.model.is_distorted();
  for (int y = rules.spacing / 2; y < a.model.height; y += rules.spacing) {
    for (int x = rules.spacing / 2; x < a.model.width; x += rules.spacing) {
      if (a.sigma(x, y) == 0) continue;
      const Eigen::Vector3d point = b_from_a * a.point(x, y).cast<double>();
      if (point.z() < 0.1) continue;
      if (distorted && point.head<2>().squaredNorm() > 4 * point.z() * point.z())
        continue;  // where no lens model holds
      const Eigen::Vector2d pixel = project(b.model, point);
      if (!(pixel.x() > -0.5 && pixel.x() < b.model.width - 0.5 && pixel.y() > -0.5 &&
            pixel.y() < b.model.height - 0.5)) {
        continue;
      }
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      if (b.sigma(u, v) == 0) continue;
      const Eigen::Vector3d normal_a = b_from_a.rotation * a.normal(x, y).cast<double>();
      const Eigen::Vector3d normal_b = b.normal(u, v).cast<double>();
      if (normal_a.dot(normal_b) < rules.least_cosine) continue;
      const double sigma = std::hypot(a.sigma(x, y), b.sigma(u, v));
      const Eigen::Vector3d other = b.point(u, v).cast<double>();
      if (std::abs(normal_b.dot(point - other)) > rules.reach_m + 3 * sigma) continue;
      Match match;
      match.a = world_from_b * point;
      match.b = world_from_b * other;
      match.normal = world_from_b.rotation * (normal_a + normal_b).normalized();
      match.pixel_a = y * a.model.width + x;
      match.pixel_b = v * b.model.width + u;
      match.sigma = sigma;
      matches.push_back(match);
    }
  }
}

}  // namespace copresence::alignment
