#include "tools/calibrate/alignment/refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "tools/calibrate/alignment/descent.h"
#include "tools/calibrate/alignment/resistance.h"
#include "tools/calibrate/alignment/weighing.h"

namespace copresence::alignment {
namespace {

using Pair = std::pair<std::size_t, std::size_t>;

constexpr std::array<Level, 3> kCoarse{{{0.2, 10, 15}, {0.1, 10, 10}, {0.05, 10, 10}}};
constexpr double kMet_m = 0.005, kMet_rad = 0.004;  // of ends of its first level, from which all goes one way
constexpr std::array<Level, 2> kFine{{{0.1, 4, 20}, {0.05, 4, 40}}};
constexpr std::array<Level, 1> kFinest{{{0.05, 2, 25}}};
constexpr Level kJudged{0.05, 8, 1};
constexpr double kWorse = -2;  // standard errors below which what was found is thrown away
constexpr int kScoreSpacing = 6;
// What lies farther from the given pose is another place that looks alike.
constexpr double kFarthest_m = 0.35, kFarthest_rad = 0.3;
constexpr double kSamePlace_m = 0.003, kSamePlace_rad = 0.002;
constexpr std::size_t kMostFollowed = 5;
constexpr double kSeenAtAll = 0.02;  // share of points below which a pair is not worth a try

// Poses around a given one: nearer and farther, each way along and about each axis of the camera.
std::vector<Rigid3> starts_around(const Rigid3& world_from_camera) {
  std::vector<Rigid3> starts{world_from_camera};
  for (const double scale : {1.0, 2.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d way = sign * Eigen::Vector3d::Unit(axis);
        starts.push_back(world_from_camera * Rigid3{Eigen::Matrix3d::Identity(), 0.08 * scale * way});
        const Eigen::AngleAxisd turn(4 * scale * std::numbers::pi / 180, way);
        starts.push_back(world_from_camera * Rigid3{turn.toRotationMatrix(), Eigen::Vector3d::Zero()});
        // Turned about a point before the camera, so that what it sees stays in view.
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

double support(const Problem& problem, std::span<const Rigid3> poses, int spacing) {
  double sum = 0;
  for (const auto& [a, b] : problem.pairs) {
    sum += measure_agreement(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], spacing).support;
  }
  return sum;
}

// Places one camera beside those that stand already. False where nothing could be made of it.
bool place(std::span<const Surface> surfaces, std::size_t camera, const std::vector<std::size_t>& standing,
           std::vector<Rigid3>& poses) {
  Problem problem{surfaces, {camera}, {}};
  for (const std::size_t other : standing) problem.pairs.emplace_back(other, camera);
  struct Candidate {
    Rigid3 pose;
    double support;
  };
  std::vector<Candidate> candidates;
  std::vector<Rigid3> met;
  const Rigid3 given = poses[camera];
  for (const Rigid3& start : starts_around(given)) {
    poses[camera] = start;
    if (!descend(problem, std::span(kCoarse).first(1), {}, poses)) continue;
    const bool again = std::any_of(met.begin(), met.end(), [&](const Rigid3& other) {
      return is_near(poses[camera], other, kMet_m, kMet_rad);
    });
    if (again) continue;
    met.push_back(poses[camera]);
    if (!descend(problem, std::span(kCoarse).subspan(1), {}, poses) || !is_near(poses[camera], given))
      continue;
    candidates.push_back({poses[camera], support(problem, poses, kScoreSpacing)});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.support > b.support; });
  // Coarse ends lie close together where the surfaces resist little; the fine measure tells them apart.
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
    if (!descend(problem, kFine, {}, poses) || !is_near(poses[camera], given)) continue;
    const double gain = linearize(problem, poses, kFine.back()).gain;
    if (best && gain <= best_gain) continue;
    best = poses[camera];
    best_gain = gain;
  }
  poses[camera] = best.value_or(given);
  return best.has_value();
}

// What a camera shares with those that stand, its pose being off by decimetres.
double rough_overlap(std::span<const Surface> surfaces, std::span<const Rigid3> poses, std::size_t camera,
                     const std::vector<std::size_t>& standing) {
  double points = 0;
  for (const std::size_t other : standing) {
    std::vector<Match> matches;
    append_matches(surfaces[camera], poses[camera], surfaces[other], poses[other], {8, 0.3, 0.7}, matches);
    points += static_cast<double>(matches.size());
  }
  return points;
}

std::vector<Direction> directions_of(const Eigen::MatrixXd& frozen, const Resistances& resistances,
                                     std::size_t place_of_camera) {
  std::vector<Direction> out;
  for (Eigen::Index column = 0; column < frozen.cols(); ++column) {
    const Eigen::Matrix<double, 6, 1> part =
        frozen.block<6, 1>(static_cast<Eigen::Index>(6 * place_of_camera), column);
    if (part.norm() < 0.3) continue;  // another camera's
    out.push_back({part.head<3>(), part.tail<3>(), resistances.values[column]});
  }
  return out;
}

double overlap_of(const Problem& problem, std::span<const Rigid3> poses, std::size_t camera) {
  double overlap = 0;
  for (const auto& [a, b] : problem.pairs) {
    if (a != camera && b != camera) continue;
    overlap = std::max(
        overlap, measure_agreement(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], 4).overlap);
  }
  return overlap;
}

CameraRefinement::Outcome outcome_of(Weighed::Verdict verdict) {
  switch (verdict) {
    case Weighed::Verdict::kMoved:
      return CameraRefinement::Outcome::kRefined;
    case Weighed::Verdict::kKnownBetter:
      return CameraRefinement::Outcome::kKnownBetter;
    case Weighed::Verdict::kNotConfirmed:
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

  // One after the other, the camera that shares most with those that stand first.
  std::vector<std::size_t> standing{0}, waiting, refused;
  for (std::size_t camera = 1; camera < surfaces.size(); ++camera) waiting.push_back(camera);
  while (!waiting.empty()) {
    const auto next = std::max_element(waiting.begin(), waiting.end(), [&](std::size_t a, std::size_t b) {
      return rough_overlap(surfaces, poses, a, standing) < rough_overlap(surfaces, poses, b, standing);
    });
    const std::size_t camera = *next;
    waiting.erase(next);
    Problem alone{surfaces, {camera}, {}};
    for (const std::size_t other : standing) alone.pairs.emplace_back(other, camera);
    if (!place(surfaces, camera, standing, poses) || overlap_of(alone, poses, camera) < kLeastOverlap) {
      poses[camera] = given[camera];
      refused.push_back(camera);
      continue;
    }
    standing.push_back(camera);
    waiting.insert(waiting.end(), refused.begin(), refused.end());  // this one may see more of them
    refused.clear();
    outcomes[camera] = Outcome::kRefined;
  }

  Problem all{surfaces, {standing.begin() + 1, standing.end()}, {}};
  for (std::size_t i = 0; i < standing.size(); ++i) {
    for (std::size_t j = i + 1; j < standing.size(); ++j) {
      const Pair pair{standing[i], standing[j]};
      const double overlap = measure_agreement(surfaces[pair.first], poses[pair.first], surfaces[pair.second],
                                               poses[pair.second], 4)
                                 .overlap;
      if (overlap >= kSeenAtAll) all.pairs.push_back(pair);
    }
  }

  Refinement refinement;
  Resistances resistances;
  Frozen frozen;
  std::vector<Weighed> weighed;
  if (!all.moving.empty()) {
    descend(all, kFinest, {}, poses);
    const Equations equations = linearize(all, poses, kJudged, Extra::kRows);
    resistances = measure_resistance(equations);
    refinement.least_resistance = resistances.values.minCoeff();
    std::vector<Eigen::Index> weak;
    for (Eigen::Index i = 0; i < resistances.values.size(); ++i) {
      if (resistances.values[i] < kLeastResistance) weak.push_back(i);
    }
    if (!weak.empty()) {
      frozen = {resistances.directions(Eigen::all, weak), equations.motions};
      resistances.values = Eigen::VectorXd(resistances.values(weak));
      // Again from the given poses, so that nothing has slid along what does not resist.
      for (const std::size_t camera : all.moving) poses[camera] = given[camera];
      if (!descend(all, kCoarse, frozen, poses) || !descend(all, kFine, frozen, poses) ||
          !descend(all, kFinest, frozen, poses)) {
        poses.assign(given.begin(), given.end());
      }
    }
    // Not by a plain comparison: of two places that agree about as well that one must win which does not depend on
    // where the cameras were thought to be.
    if (advantage(all, poses, given) < kWorse) {
      poses.assign(given.begin(), given.end());
      for (const std::size_t camera : all.moving) outcomes[camera] = Outcome::kKept;
    } else {
      weighed = weigh(all, frozen, given, errors_m, poses);
      for (std::size_t i = 0; i < weighed.size(); ++i) {
        poses[all.moving[i]] = weighed[i].pose;
        outcomes[all.moving[i]] = outcome_of(weighed[i].verdict);
      }
    }
  }

  for (std::size_t camera = 0; camera < surfaces.size(); ++camera) {
    CameraRefinement result;
    result.outcome = outcomes[camera];
    result.world_from_camera = poses[camera];
    result.told_mm = 1000 * errors_m[camera];
    const Rigid3 motion = poses[camera] * given[camera].inverse();
    result.moved_mm = 1000 * (poses[camera].translation - given[camera].translation).norm();
    result.moved_deg = Eigen::AngleAxisd(motion.rotation).angle() * 180 / std::numbers::pi;
    const auto moving = std::find(all.moving.begin(), all.moving.end(), camera);
    const auto place = static_cast<std::size_t>(moving - all.moving.begin());
    if (moving != all.moving.end() && frozen.directions.size() > 0) {
      result.unsupported = directions_of(frozen.directions, resistances, place);
    }
    if (place < weighed.size()) {
      result.surfaces_mm = 1000 * weighed[place].surfaces_m;
      result.error_mm = 1000 * weighed[place].error_m;
      result.contradicts_told = weighed[place].contradicts;
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

}  // namespace copresence::alignment
