#include "tools/calibrate/alignment/ascent.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace copresence::alignment {
namespace {

// Matches are of whole pixels, so the gain is rough: it is looked at where the matches alone say that it is lower by
// this share.
constexpr double kLower = 0.006;
constexpr double kFarthest_m = 0.012;
constexpr int kRounds = 6;
constexpr double kFinest = 0.5;  // of the first distances, at which there is nothing more to see
constexpr double kStill_m = 3e-4;

double gain_at(const Problem& problem, const Level& level, std::span<const Rigid3> poses) {
  return linearize(problem, poses, level).gain;
}

std::vector<Rigid3> stepped(const Problem& problem, const Motions& motions, const Eigen::VectorXd& step,
                            std::span<const Rigid3> from) {
  std::vector<Rigid3> poses(from.begin(), from.end());
  for (std::size_t i = 0; i < problem.moving.size(); ++i) {
    Rigid3& pose = poses[problem.moving[i]];
    pose = motions.moved(pose, step.segment<6>(static_cast<Eigen::Index>(6 * i)));
  }
  return poses;
}

// Where the parabola through three evenly spaced values is highest, in steps from the middle one, at most one away.
double top(double before, double here, double after) {
  const double slope = (after - before) / 2, bend = before + after - 2 * here;
  if (bend >= 0) return slope > 0 ? 1 : slope < 0 ? -1 : 0;
  return std::clamp(-slope / bend, -1.0, 1.0);
}

}  // namespace

void climb(const Problem& problem, const Level& level, const Frozen& frozen, std::vector<Rigid3>& poses) {
  const bool any_frozen = frozen.directions.size() > 0;
  const Equations equations =
      linearize(problem, poses, level, Extra::kNone, any_frozen ? &frozen.motions : nullptr);
  const Eigen::Index unknowns = equations.information.rows();
  Eigen::MatrixXd free = Eigen::MatrixXd::Identity(unknowns, unknowns);
  if (any_frozen) {
    const Eigen::MatrixXd basis = frozen.directions.householderQr().householderQ();
    free = basis.rightCols(unknowns - frozen.directions.cols()).eval();
  }
  if (free.cols() == 0 || equations.gain <= 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> principal(free.transpose() * equations.information *
                                                                 free);
  const Eigen::MatrixXd directions = free * principal.eigenvectors();
  Eigen::VectorXd reach(directions.cols());
  for (Eigen::Index i = 0; i < reach.size(); ++i) {
    const double stiffness = principal.eigenvalues()[i];
    reach[i] = stiffness > 0 ? std::min(kFarthest_m, std::sqrt(2 * kLower * equations.gain / stiffness))
                             : kFarthest_m;
  }

  double gain = equations.gain, scale = 1;
  for (int round = 0; round < kRounds && scale >= kFinest; ++round) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns);
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
      const Eigen::VectorXd way = scale * reach[i] * directions.col(i);
      const double before = gain_at(problem, level, stepped(problem, equations.motions, -way, poses)),
                   after = gain_at(problem, level, stepped(problem, equations.motions, way, poses));
      step += top(before, gain, after) * way;
    }
    bool higher = false;
    for (int shorter = 0; shorter < 3 && !higher; ++shorter, step /= 2) {
      std::vector<Rigid3> there = stepped(problem, equations.motions, step, poses);
      const double gain_there = gain_at(problem, level, there);
      if (gain_there <= gain) continue;
      higher = true;
      gain = gain_there;
      poses = std::move(there);
      if (step.cwiseAbs().maxCoeff() < kStill_m) return;
    }
    if (!higher) scale /= 2;
  }
}

}  // namespace copresence::alignment
