#include "tools/calibrate/alignment/descent.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>

#include "tools/calibrate/alignment/agreement.h"

namespace copresence::alignment {
namespace {

constexpr int kFewestMatches = 60;
constexpr double kStill_m = 1e-6;

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PairMatches {
  std::size_t camera_a, camera_b;
  std::ptrdiff_t a, b;  // places among the moving cameras; -1 for one that stands still
  std::vector<Match> matches;
  std::vector<int> blocks;  // of each match
};

// The blocks of one pair's first picture, numbered from `first` on.
struct BlockGrid {
  int first, width, columns, rows;

  BlockGrid(int first_block, const CameraModel& model)
      : first(first_block),
        width(model.width),
        columns((model.width + kBlock_px - 1) / kBlock_px),
        rows((model.height + kBlock_px - 1) / kBlock_px) {}
  int count() const { return columns * rows; }
  int at(int pixel) const { return first + pixel / width / kBlock_px * columns + pixel % width / kBlock_px; }
  bool is_in(int pixel, Blocks blocks) const {
    const bool white = (pixel / width / kBlock_px + pixel % width / kBlock_px) % 2 == 0;
    return blocks == Blocks::kAll || white == (blocks == Blocks::kWhite);
  }
};

// What the matches add to the gradient, block by block of every camera's picture.
class Clusters {
 public:
  Clusters(std::span<const Surface> surfaces, Eigen::Index unknowns) : unknowns_(unknowns) {
    int blocks = 0;
    for (const Surface& surface : surfaces) {
      grids_.emplace_back(blocks, surface.model);
      blocks += grids_.back().count();
    }
    of_blocks_ = Eigen::MatrixXd::Zero(unknowns, blocks);
  }

  void add(const PairMatches& pair, const Match& match, const Vector6& part) {
    const int a = grids_[pair.camera_a].at(match.pixel_a), b = grids_[pair.camera_b].at(match.pixel_b);
    auto& both =
        of_two_.try_emplace({std::min(a, b), std::max(a, b)}, Eigen::VectorXd::Zero(unknowns_)).first->second;
    for (const auto& [place, sign] : {std::pair(pair.a, 1.0), std::pair(pair.b, -1.0)}) {
      if (place < 0) continue;
      for (const int block : {a, b}) of_blocks_.col(block).segment<6>(6 * place) += sign * part;
      both.segment<6>(6 * place) += sign * part;
    }
  }

  Eigen::MatrixXd scatter() const {
    Eigen::MatrixXd sum = of_blocks_ * of_blocks_.transpose();
    for (const auto& [blocks, part] : of_two_) sum -= part * part.transpose();
    // The difference may leave a little less than nothing.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(sum);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
           solver.eigenvectors().transpose();
  }

 private:
  Eigen::Index unknowns_;
  std::vector<BlockGrid> grids_;  // of each camera
  Eigen::MatrixXd of_blocks_;
  std::map<std::pair<int, int>, Eigen::VectorXd> of_two_;
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

Equations linearize(const Problem& problem, std::span<const Rigid3> poses, const Level& level, Extra extra,
                    const Motions* about) {
  const MatchRules rules{level.spacing, level.reach_m};
  std::vector<PairMatches> all;
  Equations equations;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int blocks = 0;
  for (const auto& [first, second] : problem.pairs) {
    const BlockGrid grid(blocks, problem.surfaces[first].model);
    blocks += grid.count();
    for (const auto& [a, b] : {std::pair(first, second), std::pair(second, first)}) {
      PairMatches pair{a, b, place_of(problem, a), place_of(problem, b), {}, {}};
      if (pair.a < 0 && pair.b < 0) continue;
      append_matches(problem.surfaces[a], poses[a], problem.surfaces[b], poses[b], rules, pair.matches);
      const auto pixel_in_first = [&, forth = a == first](const Match& match) {
        return forth ? match.pixel_a : match.pixel_b;
      };
      std::erase_if(pair.matches,
                    [&](const Match& match) { return !grid.is_in(pixel_in_first(match), problem.blocks); });
      for (const Match& match : pair.matches) {
        sum += match.a;
        pair.blocks.push_back(grid.at(pixel_in_first(match)));
      }
      equations.matches += static_cast<int>(pair.matches.size());
      all.push_back(std::move(pair));
    }
  }
  const auto unknowns = static_cast<Eigen::Index>(6 * problem.moving.size());
  equations.information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  equations.block_gains.assign(static_cast<std::size_t>(blocks), 0);
  equations.gradient = Eigen::VectorXd::Zero(unknowns);
  if (equations.matches == 0) return equations;
  equations.motions.center = sum / equations.matches;
  double squares = 0;
  for (const PairMatches& pair : all) {
    for (const Match& match : pair.matches) squares += (match.a - equations.motions.center).squaredNorm();
  }
  equations.motions.radius_m = std::max(0.1, std::sqrt(squares / equations.matches));
  if (about) equations.motions = *about;
  if (extra == Extra::kRows) equations.rows = Eigen::MatrixXd::Zero(equations.matches, unknowns);
  Eigen::Index row = 0;
  std::optional<Clusters> clusters;
  if (extra == Extra::kScatter) clusters.emplace(problem.surfaces, unknowns);
  for (const PairMatches& pair : all) {
    for (std::size_t i = 0; i < pair.matches.size(); ++i) {
      const Match& match = pair.matches[i];
      const double distance = match.distance();
      const double limit = 0.5 * level.reach_m + 4 * match.sigma;
      const double beyond = distance / limit;
      const double inside = std::max(0.0, 1 - beyond * beyond);
      const double robust = inside * inside;
      const double weight = weight_of(match.sigma) * robust;
      const double gain = weight * inside * limit * limit / 6;
      equations.gain += gain;
      equations.block_gains[static_cast<std::size_t>(pair.blocks[i])] += gain;
      const Eigen::Vector3d arm = 0.5 * (match.a + match.b) - equations.motions.center;
      Vector6 J;
      const Eigen::Vector3d turning = arm.cross(match.normal);
      J.head<3>() = turning / equations.motions.radius_m;
      J.tail<3>() = match.normal;
      for (const auto& [place, sign] : {std::pair(pair.a, 1.0), std::pair(pair.b, -1.0)}) {
        if (place < 0) continue;
        equations.gradient.segment<6>(6 * place) += sign * weight * distance * J;
        equations.information.block<6, 6>(6 * place, 6 * place) += weight * J * J.transpose();
        if (extra == Extra::kRows && robust > 0)
          equations.rows.block<1, 6>(row, 6 * place) = sign * J.transpose();
      }
      if (clusters) clusters->add(pair, match, weight * distance * J);
      if (pair.a >= 0 && pair.b >= 0) {
        equations.information.block<6, 6>(6 * pair.a, 6 * pair.b) -= weight * J * J.transpose();
        equations.information.block<6, 6>(6 * pair.b, 6 * pair.a) -= weight * J * J.transpose();
      }
      ++row;
    }
  }
  if (clusters) equations.scatter = clusters->scatter();
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
          linearize(problem, poses, level, Extra::kNone, any_frozen ? &frozen.motions : nullptr);
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
