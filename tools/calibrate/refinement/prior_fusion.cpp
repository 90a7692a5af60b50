#include "tools/calibrate/refinement/prior_fusion.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/calibrate/refinement/score_ascent.h"

namespace copresence::calibrate {
namespace {

constexpr IcpLevel kFusion{0.05, 4, 1};
constexpr std::array<IcpLevel, 1> kHalf{{{0.05, 4, 15}}};
// With six degrees of freedom, chi squared exceeds this value by chance once in 1000 cases.
constexpr double kSurprising = 22.5;
constexpr double kWorthMoving = 0.7;  // A pose moves only if its new error is below this share of the old.
constexpr double kConfirmed = 2;      // Minimum t score on the blocks that were left out.
constexpr double kHardlyFixed = 0.1;  // Largest share of a camera's parameters that may be fixed.
constexpr double kFirm_m = 1e-7;      // Error of a pose that must not move.

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Mean square shift of points over all directions, from the variances of a camera's six parameters.
// All three shifts move a point, but only two of the three rotations.
double mean_square(const Vector6& variances) {
  return variances.tail<3>().sum() + 2.0 / 3 * variances.head<3>().sum();
}
double variance_of(double error_m) {
  return error_m * error_m / 5;
}

// Error of poses fitted to surfaces alone, in the directions that may move.
struct SurfaceEstimate {
  Motions motions;
  Eigen::MatrixXd free;        // Orthonormal columns.
  Eigen::MatrixXd covariance;  // Covariance of the free parameters.
};

std::optional<SurfaceEstimate> estimate_at(const IcpProblem& problem, const FixedDirections& fixed,
                                           std::span<const Rigid3> poses) {
  const bool any_fixed = fixed.directions.size() > 0;
  const NormalEquations equations =
      normal_equations(problem, poses, kFusion, Extra::kScatter, any_fixed ? &fixed.motions : nullptr);
  const Eigen::Index unknowns = equations.information.rows();
  SurfaceEstimate estimate{equations.motions, Eigen::MatrixXd::Identity(unknowns, unknowns), {}};
  if (any_fixed) {
    const Eigen::MatrixXd basis = fixed.directions.householderQr().householderQ();
    estimate.free = basis.rightCols(unknowns - fixed.directions.cols());
  }
  const Eigen::Index numbers = estimate.free.cols();
  const auto blocks = static_cast<Eigen::Index>(std::count_if(
      equations.block_scores.begin(), equations.block_scores.end(), [](double score) { return score > 0; }));
  if (numbers == 0 || blocks < 2 * numbers) return {};
  const Eigen::LDLT<Eigen::MatrixXd> information(estimate.free.transpose() * equations.information *
                                                 estimate.free);
  if (information.info() != Eigen::Success || information.vectorD().minCoeff() <= 0) return {};
  const Eigen::MatrixXd half =
      information.solve(estimate.free.transpose() * equations.scatter * estimate.free);
  // The residuals of a fit are smaller than the errors of the data. The factor corrects this by the
  // degrees of freedom.
  estimate.covariance = information.solve(half.transpose()) *
                        (static_cast<double>(blocks) / static_cast<double>(blocks - numbers));
  estimate.covariance.diagonal().array() += 1e-14;
  return estimate;
}

// Estimates systematic errors, which residuals do not show, as half of the distance between ICP's
// poses and those of highest score. Returns metres for each camera, RMS over all directions.
std::vector<double> systematic_errors(const IcpProblem& problem, const FixedDirections& fixed,
                                      const Motions& motions, std::span<const Rigid3> found) {
  std::vector<Rigid3> raised(found.begin(), found.end());
  maximise_score(problem, kFusion, fixed, raised);
  std::vector<double> errors_m;
  for (const std::size_t camera : problem.moving) {
    const Vector6 apart = motions.between(found[camera], raised[camera]);
    errors_m.push_back(std::sqrt(mean_square(apart.cwiseAbs2())) / 2);
  }
  return errors_m;
}

// The given poses of the moving cameras and their known errors.
class Prior {
 public:
  Prior(const IcpProblem& problem, std::span<const Rigid3> given, std::span<const double> errors_m)
      : problem_(problem), given_(given) {
    for (const std::size_t camera : problem.moving) variances_.push_back(variance_of(errors_m[camera]));
  }

  std::size_t cameras() const { return variances_.size(); }
  bool is_known(std::size_t i) const { return variances_[i] > 0; }
  double variance(std::size_t i) const { return variances_[i]; }
  void enlarge(std::size_t i, double times) { variances_[i] *= times; }
  void hold(std::size_t i) { variances_[i] = variance_of(kFirm_m); }

  /// Motions from the fitted poses to the given ones.
  Eigen::VectorXd to_given(const Motions& motions, std::span<const Rigid3> found) const {
    Eigen::VectorXd back(static_cast<Eigen::Index>(6 * cameras()));
    for (std::size_t i = 0; i < cameras(); ++i) {
      const std::size_t camera = problem_.moving[i];
      back.segment<6>(static_cast<Eigen::Index>(6 * i)) = motions.between(found[camera], given_[camera]);
    }
    return back;
  }

  struct Posterior {
    std::vector<Rigid3> poses;
    Eigen::MatrixXd covariance;  // Covariance of the moving cameras' parameters.
  };
  Posterior posterior(const SurfaceEstimate& estimate, std::span<const Rigid3> found) const {
    Eigen::VectorXd certainty = Eigen::VectorXd::Zero(estimate.free.rows());
    for (std::size_t i = 0; i < cameras(); ++i) {
      if (is_known(i)) certainty.segment<6>(static_cast<Eigen::Index>(6 * i)).setConstant(1 / variances_[i]);
    }
    const Eigen::MatrixXd& F = estimate.free;
    const Eigen::MatrixXd before = F.transpose() * certainty.asDiagonal() * F;
    // C is estimate.covariance, and P^-1 is `before`. The result is (C^-1 + P^-1)^-1 = (1 + C
    // P^-1)^-1 C.
    const Eigen::MatrixXd system =
        Eigen::MatrixXd::Identity(before.rows(), before.cols()) + estimate.covariance * before;
    const Eigen::MatrixXd together = system.partialPivLu().solve(estimate.covariance);
    const Eigen::VectorXd pull =
        F.transpose() * certainty.cwiseProduct(to_given(estimate.motions, found)).eval();
    const Eigen::VectorXd step = F * (together * pull);
    Posterior result{{found.begin(), found.end()}, F * together * F.transpose()};
    for (std::size_t i = 0; i < cameras(); ++i) {
      Rigid3& pose = result.poses[problem_.moving[i]];
      pose = estimate.motions.moved(pose, step.segment<6>(static_cast<Eigen::Index>(6 * i)));
    }
    return result;
  }

 private:
  const IcpProblem& problem_;
  std::span<const Rigid3> given_;
  std::vector<double> variances_;  // Variance of each parameter of a camera, metre^2; 0 if unknown.
};

void append_differences(std::span<const double> before, std::span<const double> after,
                        std::vector<double>& differences) {
  for (std::size_t block = 0; block < after.size(); ++block) {
    if (after[block] > 0 || before[block] > 0) differences.push_back(after[block] - before[block]);
  }
}

double t_score(std::span<const double> differences) {
  if (differences.size() < 2) return 0;
  double sum = 0, squares = 0;
  for (const double difference : differences) {
    sum += difference;
    squares += difference * difference;
  }
  const auto count = static_cast<double>(differences.size());
  const double spread = (squares - sum * sum / count) * count / (count - 1);
  return spread > 0 ? sum / std::sqrt(spread) : 0;
}

// Cross-validation: fits poses to half of the blocks. Returns true if they agree better than the
// given poses on the other half, by more than chance.
bool is_cross_validated(const IcpProblem& problem, const FixedDirections& fixed,
                        std::span<const Rigid3> given, const Prior& prior, std::span<const Rigid3> found) {
  std::vector<double> gained;
  for (const auto& [fitted, judged] :
       {std::pair(Blocks::kWhite, Blocks::kBlack), std::pair(Blocks::kBlack, Blocks::kWhite)}) {
    IcpProblem half = problem;
    half.blocks = fitted;
    std::vector<Rigid3> poses(found.begin(), found.end());
    if (!run_icp(half, kHalf, fixed, poses)) return false;
    const auto estimate = estimate_at(half, fixed, poses);
    if (!estimate) return false;
    half.blocks = judged;
    const auto after = normal_equations(half, prior.posterior(*estimate, poses).poses, kFusion).block_scores,
               before = normal_equations(half, given, kFusion).block_scores;
    append_differences(before, after, gained);
  }
  return t_score(gained) > kConfirmed;
}

}  // namespace

double paired_t_score(const IcpProblem& problem, std::span<const Rigid3> poses,
                      std::span<const Rigid3> others) {
  std::vector<double> differences;
  append_differences(normal_equations(problem, others, kFusion).block_scores,
                     normal_equations(problem, poses, kFusion).block_scores, differences);
  return t_score(differences);
}

std::vector<FusedPose> fuse_with_prior(const IcpProblem& problem, const FixedDirections& fixed,
                                       std::span<const Rigid3> given, std::span<const double> errors_m,
                                       std::span<const Rigid3> found) {
  using Verdict = FusedPose::Verdict;
  Prior prior(problem, given, errors_m);
  std::vector<FusedPose> fused(prior.cameras());
  for (std::size_t i = 0; i < fused.size(); ++i) fused[i].pose = found[problem.moving[i]];
  const auto keep = [&](std::size_t i, Verdict verdict) {
    prior.hold(i);
    fused[i].verdict = verdict;
    fused[i].error_m = errors_m[problem.moving[i]];
  };
  const auto estimate = estimate_at(problem, fixed, found);
  if (!estimate) {  // There are too few blocks to estimate an error.
    for (std::size_t i = 0; i < fused.size(); ++i) {
      if (!prior.is_known(i)) continue;
      keep(i, Verdict::kPriorBetter);
      fused[i].pose = given[problem.moving[i]];
    }
    return fused;
  }

  const Eigen::MatrixXd& F = estimate->free;
  const Eigen::MatrixXd surfaces = F * estimate->covariance * F.transpose();
  const Eigen::VectorXd back = prior.to_given(estimate->motions, found);
  for (std::size_t i = 0; i < fused.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    fused[i].surfaces_m = std::sqrt(mean_square(surfaces.diagonal().segment<6>(at)));
    if (!prior.is_known(i)) continue;
    Eigen::Matrix<double, 6, 6> both = surfaces.block<6, 6>(at, at);
    both.diagonal().array() += prior.variance(i);
    const double surprise = back.segment<6>(at).dot(both.ldlt().solve(back.segment<6>(at)));
    fused[i].contradicts = surprise > kSurprising;
    if (fused[i].contradicts) prior.enlarge(i, surprise / 6);
  }

  auto posterior = prior.posterior(*estimate, found);
  // In fixed directions a pose keeps the error of the given pose.
  const auto fixed_share = [&](std::size_t i) -> Vector6 {
    if (fixed.directions.size() == 0) return Vector6::Zero();
    return fixed.directions.middleRows<6>(static_cast<Eigen::Index>(6 * i)).rowwise().squaredNorm();
  };
  const auto error_of = [&](std::size_t i) {
    const Vector6 moving = posterior.covariance.diagonal().segment<6>(static_cast<Eigen::Index>(6 * i));
    return std::sqrt(mean_square(moving + prior.variance(i) * fixed_share(i)));
  };
  bool any_held = false;
  for (std::size_t i = 0; i < fused.size(); ++i) {
    if (!prior.is_known(i) || fused[i].contradicts) continue;
    // Surfaces that are less accurate than the prior may still be better in some directions. The
    // risk outweighs that gain.
    const double prior_m = errors_m[problem.moving[i]];
    if (error_of(i) < kWorthMoving * prior_m && fused[i].surfaces_m < prior_m) continue;
    keep(i, Verdict::kPriorBetter);
    any_held = true;
  }
  const auto may_move = [&](std::size_t i) {
    return errors_m[problem.moving[i]] > 0 && fused[i].verdict == Verdict::kMoved;
  };
  bool any_known_moves = false;
  for (std::size_t i = 0; i < fused.size(); ++i) any_known_moves = any_known_moves || may_move(i);
  if (any_known_moves && !is_cross_validated(problem, fixed, given, prior, found)) {
    for (std::size_t i = 0; i < fused.size(); ++i) {
      if (may_move(i)) keep(i, Verdict::kNotConfirmed);
    }
    any_held = true;
  }
  if (any_held) posterior = prior.posterior(*estimate, found);
  std::vector<double> systematic_m(fused.size(), 0);
  for (std::size_t i = 0; i < fused.size(); ++i) {
    if (prior.is_known(i)) continue;
    systematic_m = systematic_errors(problem, fixed, estimate->motions, found);
    break;
  }
  for (std::size_t i = 0; i < fused.size(); ++i) {
    const std::size_t camera = problem.moving[i];
    const bool kept = fused[i].verdict != Verdict::kMoved;
    fused[i].pose = kept ? given[camera] : posterior.poses[camera];
    if (kept) continue;
    if (prior.is_known(i)) {
      fused[i].error_m = error_of(i);
    } else if (fixed_share(i).sum() < kHardlyFixed) {
      fused[i].error_m = std::hypot(error_of(i), systematic_m[i]);
    }
  }
  return fused;
}

}  // namespace copresence::calibrate
