#include "tools/calibrate/refinement/score_ascent.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace copresence::calibrate {
namespace {

// Matches are pairs of whole pixels, so the score is not smooth. Therefore it is evaluated at
// distances that matter: where the normal equations predict a score lower by this share.
constexpr double kLower = 0.006;
constexpr double kFarthest_m = 0.012;
constexpr int kRounds = 6;
// The search ends when the distances are below this fraction of the first ones, since noise then
// dominates the score.
constexpr double kFinest = 0.5;
constexpr double kStill_m = 3e-4;

double score_at(const IcpProblem& problem, const IcpLevel& level, std::span<const Rigid3> poses) {
  return normal_equations(problem, poses, level).score;
}

std::vector<Rigid3> stepped(const IcpProblem& problem, const Motions& motions, const Eigen::VectorXd& step,
                            std::span<const Rigid3> from) {
  std::vector<Rigid3> poses(from.begin(), from.end());
  for (std::size_t i = 0; i < problem.moving.size(); ++i) {
    Rigid3& pose = poses[problem.moving[i]];
    pose = motions.moved(pose, step.segment<6>(static_cast<Eigen::Index>(6 * i)));
  }
  return poses;
}

// Position of the maximum of the parabola through three evenly spaced values, in steps from the
// middle value. The result is limited to one step.
double maximum(double before, double here, double after) {
  const double slope = (after - before) / 2, bend = before + after - 2 * here;
  if (bend >= 0) return slope > 0 ? 1 : slope < 0 ? -1 : 0;
  return std::clamp(-slope / bend, -1.0, 1.0);
}

}  // namespace

void maximise_score(const IcpProblem& problem, const IcpLevel& level, const FixedDirections& fixed,
                    std::vector<Rigid3>& poses) {
  const bool any_fixed = fixed.directions.size() > 0;
  const NormalEquations equations =
      normal_equations(problem, poses, level, Extra::kNone, any_fixed ? &fixed.motions : nullptr);
  const Eigen::Index unknowns = equations.information.rows();
  Eigen::MatrixXd free = Eigen::MatrixXd::Identity(unknowns, unknowns);
  if (any_fixed) {
    const Eigen::MatrixXd basis = fixed.directions.householderQr().householderQ();
    free = basis.rightCols(unknowns - fixed.directions.cols()).eval();
  }
  if (free.cols() == 0 || equations.score <= 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> principal(free.transpose() * equations.information *
                                                                 free);
  const Eigen::MatrixXd directions = free * principal.eigenvectors();
  Eigen::VectorXd reach(directions.cols());
  for (Eigen::Index i = 0; i < reach.size(); ++i) {
    const double stiffness = principal.eigenvalues()[i];
    reach[i] = stiffness > 0 ? std::min(kFarthest_m, std::sqrt(2 * kLower * equations.score / stiffness))
                             : kFarthest_m;
  }

  double score = equations.score, scale = 1;
  for (int round = 0; round < kRounds && scale >= kFinest; ++round) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns);
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
      const Eigen::VectorXd offset = scale * reach[i] * directions.col(i);
      const double before = score_at(problem, level, stepped(problem, equations.motions, -offset, poses)),
                   after = score_at(problem, level, stepped(problem, equations.motions, offset, poses));
      step += maximum(before, score, after) * offset;
    }
    bool higher = false;
    for (int shorter = 0; shorter < 3 && !higher; ++shorter, step /= 2) {
      std::vector<Rigid3> there = stepped(problem, equations.motions, step, poses);
      const double score_there = score_at(problem, level, there);
      if (score_there <= score) continue;
      higher = true;
      score = score_there;
      poses = std::move(there);
      if (step.cwiseAbs().maxCoeff() < kStill_m) return;
    }
    if (!higher) scale /= 2;
  }
}

}  // namespace copresence::calibrate
