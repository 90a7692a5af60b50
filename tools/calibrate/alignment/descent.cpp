#include "tools/calibrate/alignment/descent.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "tools/calibrate/alignment/agreement.h"

namespace copresence::alignment {
namespace {

constexpr int kFewestMatches = 60;
constexpr double kStill_m = 1e-6;

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PairMatches {
  std::ptrdiff_t a, b;  // places among the moving cameras; -1 for one that stands still
  std::vector<Match> matches;
};

std::ptrdiff_t place_of(const Problem& problem, std::size_t camera) {
  const auto found = std::find(problem.moving.begin(), problem.moving.end(), camera);
  return found == problem.moving.end() ? -1 : found - problem.moving.begin();
}

}  // namespace

Rigid3 Motions::moved(const Rigid3& pose, const Vector6& motion) const {
  const Eigen::Vector3d turn = motion.head<3>() / radius_m;
  const double angle = turn.norm();
  const Eigen::Matrix3d rotation =
      angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  return {Eigen::Quaterniond(rotation * pose.rotation).normalized().toRotationMatrix(),
          rotation * (pose.translation - center) + center + motion.tail<3>()};
}

Vector6 Motions::between(const Rigid3& from, const Rigid3& to) const {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.transpose());
  Vector6 motion;
  motion.head<3>() = turn.axis() * turn.angle() * radius_m;
  motion.tail<3>() = to.translation - (turn.toRotationMatrix() * (from.translation - center) + center);
  return motion;
}

Equations linearize(const Problem& problem, std::span<const Rigid3> poses, const Level& level, bool keep_rows,
                    const Motions* about) {
  const MatchRules rules{level.spacing, level.reach_m};
  std::vector<PairMatches> all;
  Equations equations;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [first, second] : problem.pairs) {
    for (const auto& [a, b] : {std::pair(first, second), std::pair(second, first)}) {
      PairMatches pair{place_of(problem, a), place_of(problem, b), {}};
      if (pair.a < 0 && pair.b < 0) continue;
      append_matches(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], rules, pair.matches);
      for (const Match& match : pair.matches) sum += match.a;
      equations.matches += static_cast<int>(pair.matches.size());
      all.push_back(std::move(pair));
    }
  }
  const auto unknowns = static_cast<Eigen::Index>(6 * problem.moving.size());
  equations.information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  equations.knowledge = Eigen::MatrixXd::Zero(unknowns, unknowns);
  equations.gradient = Eigen::VectorXd::Zero(unknowns);
  if (equations.matches == 0) return equations;
  equations.motions.center = sum / equations.matches;
  double squares = 0;
  for (const PairMatches& pair : all) {
    for (const Match& match : pair.matches) squares += (match.a - equations.motions.center).squaredNorm();
  }
  equations.motions.radius_m = std::max(0.1, std::sqrt(squares / equations.matches));
  if (about) equations.motions = *about;
  if (keep_rows) equations.rows = Eigen::MatrixXd::Zero(equations.matches, unknowns);
  Eigen::Index row = 0;
  for (const PairMatches& pair : all) {
    for (const Match& match : pair.matches) {
      const double distance = match.distance();
      const double limit = 0.5 * level.reach_m + 2.5 * match.sigma;
      const double beyond = distance / limit;
      const double inside = std::max(0.0, 1 - beyond * beyond);
      const double robust = inside * inside;
      const double weight = weight_of(match.sigma) * robust;
      equations.gain += weight * inside * limit * limit / 6;
      // Both ways the same surface is matched: half of each.
      const double known = robust * 0.5 * level.spacing * level.spacing /
                           (kErrorBlob_px * kErrorBlob_px * match.sigma * match.sigma);
      const Eigen::Vector3d arm = 0.5 * (match.a + match.b) - equations.motions.center;
      Vector6 J;
      const Eigen::Vector3d turning = arm.cross(match.normal);
      J.head<3>() = turning / equations.motions.radius_m;
      J.tail<3>() = match.normal;
      for (const auto& [place, sign] : {std::pair(pair.a, 1.0), std::pair(pair.b, -1.0)}) {
        if (place < 0) continue;
        equations.gradient.segment<6>(6 * place) += sign * weight * distance * J;
        equations.information.block<6, 6>(6 * place, 6 * place) += weight * J * J.transpose();
        equations.knowledge.block<6, 6>(6 * place, 6 * place) += known * J * J.transpose();
        if (keep_rows && robust > 0) equations.rows.block<1, 6>(row, 6 * place) = sign * J.transpose();
      }
      if (pair.a >= 0 && pair.b >= 0) {
        equations.information.block<6, 6>(6 * pair.a, 6 * pair.b) -= weight * J * J.transpose();
        equations.information.block<6, 6>(6 * pair.b, 6 * pair.a) -= weight * J * J.transpose();
        equations.knowledge.block<6, 6>(6 * pair.a, 6 * pair.b) -= known * J * J.transpose();
        equations.knowledge.block<6, 6>(6 * pair.b, 6 * pair.a) -= known * J * J.transpose();
      }
      ++row;
    }
  }
  return equations;
}

bool descend(const Problem& problem, std::span<const Level> levels, const Frozen& frozen,
             std::vector<Rigid3>& poses) {
  const auto unknowns = static_cast<Eigen::Index>(6 * problem.moving.size());
  const bool any_frozen = frozen.directions.size() > 0;
  assert(!any_frozen || frozen.directions.rows() == unknowns);
  for (const Level& level : levels) {
    for (int iteration = 0; iteration < level.iterations; ++iteration) {
      const Equations equations =
          linearize(problem, poses, level, false, any_frozen ? &frozen.motions : nullptr);
      if (equations.matches < kFewestMatches) return false;
      Eigen::MatrixXd A = equations.information;
      A.diagonal().array() += 1e-6 * A.diagonal().maxCoeff();
      Eigen::VectorXd g = equations.gradient;
      if (any_frozen) {
        const Eigen::MatrixXd held = frozen.directions * frozen.directions.transpose();
        const Eigen::MatrixXd free = Eigen::MatrixXd::Identity(unknowns, unknowns) - held;
        A = free * A * free + held * A.diagonal().maxCoeff();
        g = free * g;
      }
      const Eigen::VectorXd step = -A.ldlt().solve(g);
      if (!step.allFinite()) return false;
      for (std::size_t i = 0; i < problem.moving.size(); ++i) {
        Rigid3& pose = poses[problem.moving[i]];
        pose = equations.motions.moved(pose, step.segment<6>(static_cast<Eigen::Index>(6 * i)));
      }
      if (step.cwiseAbs().maxCoeff() < kStill_m) break;
    }
  }
  return true;
}

}  // namespace copresence::alignment
