#include "tools/calibrate/refinement/refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "tools/calibrate/refinement/icp.h"
#include "tools/calibrate/refinement/prior_fusion.h"

namespace copresence::calibrate {
namespace {

using Pair = std::pair<std::size_t, std::size_t>;

constexpr std::array<IcpLevel, 3> kCoarse{{{0.2, 10, 15}, {0.1, 10, 10}, {0.05, 10, 10}}};
// If two starting poses are this close after the first level, they would end at the same pose.
constexpr double kMet_m = 0.005, kMet_rad = 0.004;
constexpr std::array<IcpLevel, 2> kFine{{{0.1, 4, 20}, {0.05, 4, 40}}};
constexpr std::array<IcpLevel, 1> kFinest{{{0.05, 2, 25}}};
constexpr IcpLevel kJudged{0.05, 8, 1};
constexpr double kWorse = -2;  // Results with a lower paired t score are discarded.
constexpr int kScoreSpacing = 6;
// A result farther from the given pose fits another place that looks alike.
constexpr double kFarthest_m = 0.35, kFarthest_rad = 0.3;
constexpr double kSamePlace_m = 0.003, kSamePlace_rad = 0.002;
constexpr std::size_t kMostFollowed = 5;
constexpr double kSeenAtAll = 0.02;  // Minimum overlap of a pair that is used.

// Starting poses: the given one, and poses shifted and turned to both sides along each camera axis.
std::vector<Rigid3> starts_around(const Rigid3& world_from_camera) {
  std::vector<Rigid3> starts{world_from_camera};
  for (const double scale : {1.0, 2.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d way = sign * Eigen::Vector3d::Unit(axis);
        starts.push_back(world_from_camera * Rigid3{Eigen::Matrix3d::Identity(), 0.08 * scale * way});
        const Eigen::AngleAxisd turn(4 * scale * std::numbers::pi / 180, way);
        starts.push_back(world_from_camera * Rigid3{turn.toRotationMatrix(), Eigen::Vector3d::Zero()});
        // The pose turns about a point ahead of the camera, so that the same objects stay in view.
        const Eigen::Vector3d ahead(0, 0, 2);
        starts.push_back(world_from_camera * Rigid3{turn.toRotationMatrix(), ahead - turn * ahead});
      }
    }
  }
  return starts;
}

bool is_near(const Rigid3& pose, const Rigid3& other, double metres = kFarthest_m,
             double radians = kFarthest_rad) {
  return (pose.translation - other.translation).norm() < metres &&
         Eigen::AngleAxisd(pose.rotation.transpose() * other.rotation).angle() < radians;
}

double score_of(const IcpProblem& problem, std::span<const Rigid3> poses, int spacing) {
  double sum = 0;
  for (const auto& [a, b] : problem.pairs) {
    sum += measure_agreement(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], spacing).score;
  }
  return sum;
}

// Places one camera beside those already placed. Returns false if no starting pose succeeds.
bool place(std::span<const Surface> surfaces, std::size_t camera, const std::vector<std::size_t>& placed,
           std::vector<Rigid3>& poses) {
  IcpProblem problem{surfaces, {camera}, {}};
  for (const std::size_t other : placed) problem.pairs.emplace_back(other, camera);
  struct Candidate {
    Rigid3 pose;
    double score;
  };
  std::vector<Candidate> candidates;
  std::vector<Rigid3> met;
  const Rigid3 given = poses[camera];
  for (const Rigid3& start : starts_around(given)) {
    poses[camera] = start;
    if (!run_icp(problem, std::span(kCoarse).first(1), {}, poses)) continue;
    const bool again = std::any_of(met.begin(), met.end(), [&](const Rigid3& other) {
      return is_near(poses[camera], other, kMet_m, kMet_rad);
    });
    if (again) continue;
    met.push_back(poses[camera]);
    if (!run_icp(problem, std::span(kCoarse).subspan(1), {}, poses) || !is_near(poses[camera], given))
      continue;
    candidates.push_back({poses[camera], score_of(problem, poses, kScoreSpacing)});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  // Coarse results lie close together along directions that are hardly observable. Only their fine
  // scores differ clearly.
  std::vector<Rigid3> followed;
  std::optional<Rigid3> best;
  double best_gain = 0;
  for (const Candidate& candidate : candidates) {
    if (followed.size() == kMostFollowed) break;
    const bool again = std::any_of(followed.begin(), followed.end(), [&](const Rigid3& other) {
      return is_near(candidate.pose, other, kSamePlace_m, kSamePlace_rad);
    });
    if (again) continue;
    followed.push_back(candidate.pose);
    poses[camera] = candidate.pose;
    if (!run_icp(problem, kFine, {}, poses) || !is_near(poses[camera], given)) continue;
    const double score = normal_equations(problem, poses, kFine.back()).score;
    if (best && score <= best_gain) continue;
    best = poses[camera];
    best_gain = score;
  }
  poses[camera] = best.value_or(given);
  return best.has_value();
}

// Returns the number of matches with the placed cameras. The large search distance allows poses
// that are wrong by decimetres.
double rough_overlap(std::span<const Surface> surfaces, std::span<const Rigid3> poses, std::size_t camera,
                     const std::vector<std::size_t>& placed) {
  double points = 0;
  for (const std::size_t other : placed) {
    std::vector<Match> matches;
    append_matches(surfaces[camera], poses[camera], surfaces[other], poses[other], {8, 0.3}, matches);
    points += static_cast<double>(matches.size());
  }
  return points;
}

std::vector<Direction> directions_of(const Eigen::MatrixXd& fixed, const Observability& observability,
                                     std::size_t index) {
  std::vector<Direction> out;
  for (Eigen::Index column = 0; column < fixed.cols(); ++column) {
    const Eigen::Matrix<double, 6, 1> part = fixed.block<6, 1>(static_cast<Eigen::Index>(6 * index), column);
    if (part.norm() < 0.3) continue;  // In this direction, mostly another camera moves.
    out.push_back({part.head<3>(), part.tail<3>(), observability.values[column]});
  }
  return out;
}

double overlap_of(const IcpProblem& problem, std::span<const Rigid3> poses, std::size_t camera) {
  double overlap = 0;
  for (const auto& [a, b] : problem.pairs) {
    if (a != camera && b != camera) continue;
    overlap = std::max(
        overlap, measure_agreement(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], 4).overlap);
  }
  return overlap;
}

CameraRefinement::Outcome outcome_of(FusedPose::Verdict verdict) {
  switch (verdict) {
    case FusedPose::Verdict::kMoved:
      return CameraRefinement::Outcome::kRefined;
    case FusedPose::Verdict::kPriorBetter:
      return CameraRefinement::Outcome::kPriorBetter;
    case FusedPose::Verdict::kNotConfirmed:
      return CameraRefinement::Outcome::kNotConfirmed;
  }
  return CameraRefinement::Outcome::kRefined;
}

}  // namespace

Refinement refine(std::span<const Surface> surfaces, std::span<const Rigid3> given,
                  std::span<const double> errors_m) {
  assert(!surfaces.empty() && surfaces.size() == given.size() && surfaces.size() == errors_m.size());
  using Outcome = CameraRefinement::Outcome;
  std::vector<Rigid3> poses(given.begin(), given.end());
  std::vector<Outcome> outcomes(surfaces.size(), Outcome::kNoOverlap);
  outcomes[0] = Outcome::kReference;

  // Place next the camera whose surfaces have most in common with those of the cameras already
  // placed.
  std::vector<std::size_t> placed{0}, waiting, refused;
  for (std::size_t camera = 1; camera < surfaces.size(); ++camera) waiting.push_back(camera);
  while (!waiting.empty()) {
    const auto next = std::max_element(waiting.begin(), waiting.end(), [&](std::size_t a, std::size_t b) {
      return rough_overlap(surfaces, poses, a, placed) < rough_overlap(surfaces, poses, b, placed);
    });
    const std::size_t camera = *next;
    waiting.erase(next);
    IcpProblem alone{surfaces, {camera}, {}};
    for (const std::size_t other : placed) alone.pairs.emplace_back(other, camera);
    if (!place(surfaces, camera, placed, poses) || overlap_of(alone, poses, camera) < kLeastOverlap) {
      poses[camera] = given[camera];
      refused.push_back(camera);
      continue;
    }
    placed.push_back(camera);
    waiting.insert(waiting.end(), refused.begin(),
                   refused.end());  // Other cameras may overlap with the placed one.
    refused.clear();
    outcomes[camera] = Outcome::kRefined;
  }

  IcpProblem all{surfaces, {placed.begin() + 1, placed.end()}, {}};
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t j = i + 1; j < placed.size(); ++j) {
      const Pair pair{placed[i], placed[j]};
      const double overlap = measure_agreement(surfaces[pair.first], poses[pair.first], surfaces[pair.second],
                                               poses[pair.second], 4)
                                 .overlap;
      if (overlap >= kSeenAtAll) all.pairs.push_back(pair);
    }
  }

  Refinement refinement;
  Observability observability;
  FixedDirections fixed;
  std::vector<FusedPose> fused;
  if (!all.moving.empty()) {
    run_icp(all, kFinest, {}, poses);
    const NormalEquations equations = normal_equations(all, poses, kJudged, Extra::kRows);
    observability = measure_observability(equations);
    refinement.least_observability = observability.values.minCoeff();
    std::vector<Eigen::Index> weak;
    for (Eigen::Index i = 0; i < observability.values.size(); ++i) {
      if (observability.values[i] < kLeastObservability) weak.push_back(i);
    }
    if (!weak.empty()) {
      fixed = {observability.directions(Eigen::all, weak), equations.motions};
      observability.values = Eigen::VectorXd(observability.values(weak));
      // Start again from the given poses, so that no camera has moved in these directions.
      for (const std::size_t camera : all.moving) poses[camera] = given[camera];
      if (!run_icp(all, kCoarse, fixed, poses) || !run_icp(all, kFine, fixed, poses) ||
          !run_icp(all, kFinest, fixed, poses)) {
        poses.assign(given.begin(), given.end());
      }
    }
    // A significance test: a choice between nearly equal poses must not depend on the given pose.
    if (paired_t_score(all, poses, given) < kWorse) {
      poses.assign(given.begin(), given.end());
      for (const std::size_t camera : all.moving) outcomes[camera] = Outcome::kKept;
    } else {
      fused = fuse_with_prior(all, fixed, given, errors_m, poses);
      for (std::size_t i = 0; i < fused.size(); ++i) {
        poses[all.moving[i]] = fused[i].pose;
        outcomes[all.moving[i]] = outcome_of(fused[i].verdict);
      }
    }
  }

  for (std::size_t camera = 0; camera < surfaces.size(); ++camera) {
    CameraRefinement result;
    result.outcome = outcomes[camera];
    result.world_from_camera = poses[camera];
    result.prior_mm = 1000 * errors_m[camera];
    const Rigid3 motion = poses[camera] * given[camera].inverse();
    result.moved_mm = 1000 * (poses[camera].translation - given[camera].translation).norm();
    result.moved_deg = Eigen::AngleAxisd(motion.rotation).angle() * 180 / std::numbers::pi;
    const auto moving = std::find(all.moving.begin(), all.moving.end(), camera);
    const auto index = static_cast<std::size_t>(moving - all.moving.begin());
    if (moving != all.moving.end() && fixed.directions.size() > 0) {
      result.unobservable = directions_of(fixed.directions, observability, index);
    }
    if (index < fused.size()) {
      result.surfaces_mm = 1000 * fused[index].surfaces_m;
      result.error_mm = 1000 * fused[index].error_m;
      result.contradicts_prior = fused[index].contradicts;
    }
    refinement.cameras.push_back(std::move(result));
  }
  for (std::size_t a = 0; a < surfaces.size(); ++a) {
    for (std::size_t b = a + 1; b < surfaces.size(); ++b) {
      const PairRefinement pair{a, b, measure_agreement(surfaces[a], given[a], surfaces[b], given[b]),
                                measure_agreement(surfaces[a], poses[a], surfaces[b], poses[b])};
      if (pair.before.points + pair.after.points > 0) refinement.pairs.push_back(pair);
    }
  }
  return refinement;
}

}  // namespace copresence::calibrate
