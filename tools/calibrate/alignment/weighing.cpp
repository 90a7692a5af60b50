#include "tools/calibrate/alignment/weighing.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/calibrate/alignment/ascent.h"

namespace copresence::alignment {
namespace {

constexpr Level kWeighed{0.05, 4, 1};
constexpr std::array<Level, 1> kHalf{{{0.05, 4, 15}}};
constexpr double kSurprising = 22.5;   // chi squared of six numbers, one case in a thousand
constexpr double kWorthMoving = 0.7;   // of the known error, what may be left for a pose to be moved
constexpr double kConfirmed = 2;       // standard errors by which what was left out must agree better
constexpr double kHardlyFrozen = 0.1;  // of a camera's six numbers
constexpr double kFirm_m = 1e-7;

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Mean square shift of points all around, of a camera's six numbers: three shifts, and two of three turns move a point.
double mean_square(const Vector6& variances) {
  return variances.tail<3>().sum() + 2.0 / 3 * variances.head<3>().sum();
}
double variance_of(double error_m) {
  return error_m * error_m / 5;
}

// What the matches say around some poses, in the directions that are free.
struct Opinion {
  Motions motions;
  Eigen::MatrixXd free;        // orthonormal columns
  Eigen::MatrixXd covariance;  // of the free numbers
};

std::optional<Opinion> opinion_at(const Problem& problem, const Frozen& frozen,
                                  std::span<const Rigid3> poses) {
  const bool any_frozen = frozen.directions.size() > 0;
  const Equations equations =
      linearize(problem, poses, kWeighed, Extra::kScatter, any_frozen ? &frozen.motions : nullptr);
  const Eigen::Index unknowns = equations.information.rows();
  Opinion opinion{equations.motions, Eigen::MatrixXd::Identity(unknowns, unknowns), {}};
  if (any_frozen) {
    const Eigen::MatrixXd basis = frozen.directions.householderQr().householderQ();
    opinion.free = basis.rightCols(unknowns - frozen.directions.cols());
  }
  const Eigen::Index numbers = opinion.free.cols();
  const auto blocks = static_cast<Eigen::Index>(std::count_if(
      equations.block_gains.begin(), equations.block_gains.end(), [](double gain) { return gain > 0; }));
  if (numbers == 0 || blocks < 2 * numbers) return {};
  const Eigen::LDLT<Eigen::MatrixXd> information(opinion.free.transpose() * equations.information *
                                                 opinion.free);
  if (information.info() != Eigen::Success || information.vectorD().minCoeff() <= 0) return {};
  const Eigen::MatrixXd half = information.solve(opinion.free.transpose() * equations.scatter * opinion.free);
  // The fit has made the residuals smaller than the errors, the more so the fewer blocks there are.
  opinion.covariance = information.solve(half.transpose()) *
                       (static_cast<double>(blocks) / static_cast<double>(blocks - numbers));
  opinion.covariance.diagonal().array() += 1e-14;
  return opinion;
}

// What is systematic shows in no scatter, but in how far apart two ways of asking end: where the matches come to rest,
// and where the surfaces agree most. Half of that, metres, root mean square over points all around, by camera.
std::vector<double> systematic_errors(const Problem& problem, const Frozen& frozen, const Motions& motions,
                                      std::span<const Rigid3> found) {
  std::vector<Rigid3> climbed(found.begin(), found.end());
  climb(problem, kWeighed, frozen, climbed);
  std::vector<double> errors_m;
  for (const std::size_t camera : problem.moving) {
    const Vector6 apart = motions.between(found[camera], climbed[camera]);
    errors_m.push_back(std::sqrt(mean_square(apart.cwiseAbs2())) / 2);
  }
  return errors_m;
}

class Scales {
 public:
  Scales(const Problem& problem, std::span<const Rigid3> given, std::span<const double> errors_m)
      : problem_(problem), given_(given) {
    for (const std::size_t camera : problem.moving) variances_.push_back(variance_of(errors_m[camera]));
  }

  std::size_t cameras() const { return variances_.size(); }
  bool is_known(std::size_t i) const { return variances_[i] > 0; }
  double variance(std::size_t i) const { return variances_[i]; }
  void trust_less(std::size_t i, double times) { variances_[i] *= times; }
  void hold(std::size_t i) { variances_[i] = variance_of(kFirm_m); }

  /// From the poses found to the given ones.
  Eigen::VectorXd way_back(const Motions& motions, std::span<const Rigid3> found) const {
    Eigen::VectorXd back(static_cast<Eigen::Index>(6 * cameras()));
    for (std::size_t i = 0; i < cameras(); ++i) {
      const std::size_t camera = problem_.moving[i];
      back.segment<6>(static_cast<Eigen::Index>(6 * i)) = motions.between(found[camera], given_[camera]);
    }
    return back;
  }

  struct Balance {
    std::vector<Rigid3> poses;   // of all cameras
    Eigen::MatrixXd covariance;  // of the moving ones' numbers
  };
  Balance balance(const Opinion& opinion, std::span<const Rigid3> found) const {
    Eigen::VectorXd certainty = Eigen::VectorXd::Zero(opinion.free.rows());
    for (std::size_t i = 0; i < cameras(); ++i) {
      if (is_known(i)) certainty.segment<6>(static_cast<Eigen::Index>(6 * i)).setConstant(1 / variances_[i]);
    }
    const Eigen::MatrixXd& F = opinion.free;
    const Eigen::MatrixXd before = F.transpose() * certainty.asDiagonal() * F;
    // (C^-1 + P^-1)^-1 = (1 + C P^-1)^-1 C, which needs no inverse of C.
    const Eigen::MatrixXd system =
        Eigen::MatrixXd::Identity(before.rows(), before.cols()) + opinion.covariance * before;
    const Eigen::MatrixXd together = system.partialPivLu().solve(opinion.covariance);
    const Eigen::VectorXd pull =
        F.transpose() * certainty.cwiseProduct(way_back(opinion.motions, found)).eval();
    const Eigen::VectorXd step = F * (together * pull);
    Balance result{{found.begin(), found.end()}, F * together * F.transpose()};
    for (std::size_t i = 0; i < cameras(); ++i) {
      Rigid3& pose = result.poses[problem_.moving[i]];
      pose = opinion.motions.moved(pose, step.segment<6>(static_cast<Eigen::Index>(6 * i)));
    }
    return result;
  }

 private:
  const Problem& problem_;
  std::span<const Rigid3> given_;
  std::vector<double> variances_;  // of each of a camera's six numbers, metre^2; 0 where nobody knows
};

void append_differences(std::span<const double> before, std::span<const double> after,
                        std::vector<double>& differences) {
  for (std::size_t block = 0; block < after.size(); ++block) {
    if (after[block] > 0 || before[block] > 0) differences.push_back(after[block] - before[block]);
  }
}

double in_standard_errors(std::span<const double> differences) {
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

// Whether poses fitted on half of the blocks agree better than the given ones on the other half, by more than chance.
bool confirmed(const Problem& problem, const Frozen& frozen, std::span<const Rigid3> given,
               const Scales& scales, std::span<const Rigid3> found) {
  std::vector<double> gained;
  for (const auto& [fitted, judged] :
       {std::pair(Blocks::kWhite, Blocks::kBlack), std::pair(Blocks::kBlack, Blocks::kWhite)}) {
    Problem half = problem;
    half.blocks = fitted;
    std::vector<Rigid3> poses(found.begin(), found.end());
    if (!descend(half, kHalf, frozen, poses)) return false;
    const auto opinion = opinion_at(half, frozen, poses);
    if (!opinion) return false;
    half.blocks = judged;
    const auto after = linearize(half, scales.balance(*opinion, poses).poses, kWeighed).block_gains,
               before = linearize(half, given, kWeighed).block_gains;
    append_differences(before, after, gained);
  }
  return in_standard_errors(gained) > kConfirmed;
}

}  // namespace

double advantage(const Problem& problem, std::span<const Rigid3> poses, std::span<const Rigid3> others) {
  std::vector<double> differences;
  append_differences(linearize(problem, others, kWeighed).block_gains,
                     linearize(problem, poses, kWeighed).block_gains, differences);
  return in_standard_errors(differences);
}

std::vector<Weighed> weigh(const Problem& problem, const Frozen& frozen, std::span<const Rigid3> given,
                           std::span<const double> errors_m, std::span<const Rigid3> found) {
  using Verdict = Weighed::Verdict;
  Scales scales(problem, given, errors_m);
  std::vector<Weighed> weighed(scales.cameras());
  for (std::size_t i = 0; i < weighed.size(); ++i) weighed[i].pose = found[problem.moving[i]];
  const auto keep = [&](std::size_t i, Verdict verdict) {
    scales.hold(i);
    weighed[i].verdict = verdict;
    weighed[i].error_m = errors_m[problem.moving[i]];
  };
  const auto opinion = opinion_at(problem, frozen, found);
  if (!opinion) {  // too few surfaces to tell how far they are off
    for (std::size_t i = 0; i < weighed.size(); ++i) {
      if (!scales.is_known(i)) continue;
      keep(i, Verdict::kKnownBetter);
      weighed[i].pose = given[problem.moving[i]];
    }
    return weighed;
  }

  const Eigen::MatrixXd& F = opinion->free;
  const Eigen::MatrixXd surfaces = F * opinion->covariance * F.transpose();
  const Eigen::VectorXd back = scales.way_back(opinion->motions, found);
  for (std::size_t i = 0; i < weighed.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    weighed[i].surfaces_m = std::sqrt(mean_square(surfaces.diagonal().segment<6>(at)));
    if (!scales.is_known(i)) continue;
    Eigen::Matrix<double, 6, 6> both = surfaces.block<6, 6>(at, at);
    both.diagonal().array() += scales.variance(i);
    const double surprise = back.segment<6>(at).dot(both.ldlt().solve(back.segment<6>(at)));
    weighed[i].contradicts = surprise > kSurprising;
    if (weighed[i].contradicts) scales.trust_less(i, surprise / 6);
  }

  auto balance = scales.balance(*opinion, found);
  // In what is frozen a pose is as far off as it was given: as told, or nobody knows how far.
  const auto frozen_share = [&](std::size_t i) -> Vector6 {
    if (frozen.directions.size() == 0) return Vector6::Zero();
    return frozen.directions.middleRows<6>(static_cast<Eigen::Index>(6 * i)).rowwise().squaredNorm();
  };
  const auto error_of = [&](std::size_t i) {
    const Vector6 moving = balance.covariance.diagonal().segment<6>(static_cast<Eigen::Index>(6 * i));
    return std::sqrt(mean_square(moving + scales.variance(i) * frozen_share(i)));
  };
  bool any_held = false;
  for (std::size_t i = 0; i < weighed.size(); ++i) {
    if (!scales.is_known(i) || weighed[i].contradicts) continue;
    // Surfaces that know less than what is told know more in some directions only, too little to risk the others for.
    const double told_m = errors_m[problem.moving[i]];
    if (error_of(i) < kWorthMoving * told_m && weighed[i].surfaces_m < told_m) continue;
    keep(i, Verdict::kKnownBetter);
    any_held = true;
  }
  const auto may_move = [&](std::size_t i) {
    return errors_m[problem.moving[i]] > 0 && weighed[i].verdict == Verdict::kMoved;
  };
  bool any_known_moves = false;
  for (std::size_t i = 0; i < weighed.size(); ++i) any_known_moves = any_known_moves || may_move(i);
  if (any_known_moves && !confirmed(problem, frozen, given, scales, found)) {
    for (std::size_t i = 0; i < weighed.size(); ++i) {
      if (may_move(i)) keep(i, Verdict::kNotConfirmed);
    }
    any_held = true;
  }
  if (any_held) balance = scales.balance(*opinion, found);
  std::vector<double> systematic_m(weighed.size(), 0);
  for (std::size_t i = 0; i < weighed.size(); ++i) {
    if (scales.is_known(i)) continue;
    systematic_m = systematic_errors(problem, frozen, opinion->motions, found);
    break;
  }
  for (std::size_t i = 0; i < weighed.size(); ++i) {
    const std::size_t camera = problem.moving[i];
    const bool kept = weighed[i].verdict != Verdict::kMoved;
    weighed[i].pose = kept ? given[camera] : balance.poses[camera];
    // A known pose moves only as far as surfaces left out of the fit confirm.
    if (kept) continue;
    if (scales.is_known(i)) {
      weighed[i].error_m = error_of(i);
    } else if (frozen_share(i).sum() < kHardlyFrozen) {
      weighed[i].error_m = std::hypot(error_of(i), systematic_m[i]);
    }
  }
  return weighed;
}

}  // namespace copresence::alignment
