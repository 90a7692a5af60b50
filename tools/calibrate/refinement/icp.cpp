#include "tools/calibrate/refinement/icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>

#include "tools/calibrate/geometry/rigid_fit.h"
#include "tools/calibrate/refinement/association.h"

namespace copresence::calibrate {
namespace {

constexpr int kFewestMatches = 60;
constexpr double kStill_m = 1e-6;

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PairMatches {
  std::size_t camera_a, camera_b;
  std::ptrdiff_t a, b;  // Indices among the moving cameras; -1 for a camera that does not move.
  std::vector<Match> matches;
  std::vector<int> blocks;
};

// The blocks of one picture, numbered from `first` on.
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

// Sums the gradient by block of every camera's picture. The sums' covariance is the scatter.
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
    for (const auto& [index, sign] : {std::pair(pair.a, 1.0), std::pair(pair.b, -1.0)}) {
      if (index < 0) continue;
      for (const int block : {a, b}) of_blocks_.col(block).segment<6>(6 * index) += sign * part;
      both.segment<6>(6 * index) += sign * part;
    }
  }

  Eigen::MatrixXd scatter() const {
    Eigen::MatrixXd sum = of_blocks_ * of_blocks_.transpose();
    for (const auto& [blocks, part] : of_two_) sum -= part * part.transpose();
    // Rounding may leave small negative eigenvalues.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(sum);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
           solver.eigenvectors().transpose();
  }

 private:
  Eigen::Index unknowns_;
  std::vector<BlockGrid> grids_;
  Eigen::MatrixXd of_blocks_;
  std::map<std::pair<int, int>, Eigen::VectorXd> of_two_;
};

std::ptrdiff_t index_of(const IcpProblem& problem, std::size_t camera) {
  const auto found = std::find(problem.moving.begin(), problem.moving.end(), camera);
  return found == problem.moving.end() ? -1 : found - problem.moving.begin();
}

}  // namespace

Rigid3 Motions::moved(const Rigid3& pose, const Vector6& motion) const {
  const Eigen::Matrix3d rotation = rotation_from_vector(motion.head<3>() / radius_m);
  return {orthonormal(rotation * pose.rotation),
          rotation * (pose.translation - center) + center + motion.tail<3>()};
}

Vector6 Motions::between(const Rigid3& from, const Rigid3& to) const {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.transpose());
  Vector6 motion;
  motion.head<3>() = turn.axis() * turn.angle() * radius_m;
  motion.tail<3>() = to.translation - (turn.toRotationMatrix() * (from.translation - center) + center);
  return motion;
}

NormalEquations normal_equations(const IcpProblem& problem, std::span<const Rigid3> poses,
                                 const IcpLevel& level, Extra extra, const Motions* about) {
  const MatchRules rules{level.spacing, level.reach_m};
  std::vector<PairMatches> all;
  NormalEquations equations;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int blocks = 0;
  for (const auto& [first, second] : problem.pairs) {
    const BlockGrid grid(blocks, problem.surfaces[first].model);
    blocks += grid.count();
    for (const auto& [a, b] : {std::pair(first, second), std::pair(second, first)}) {
      PairMatches pair{a, b, index_of(problem, a), index_of(problem, b), {}, {}};
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
  equations.block_scores.assign(static_cast<std::size_t>(blocks), 0);
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
      const double score = weight * inside * limit * limit / 6;
      equations.score += score;
      equations.block_scores[static_cast<std::size_t>(pair.blocks[i])] += score;
      const Eigen::Vector3d arm = 0.5 * (match.a + match.b) - equations.motions.center;
      Vector6 J;
      const Eigen::Vector3d turning = arm.cross(match.normal);
      J.head<3>() = turning / equations.motions.radius_m;
      J.tail<3>() = match.normal;
      for (const auto& [index, sign] : {std::pair(pair.a, 1.0), std::pair(pair.b, -1.0)}) {
        if (index < 0) continue;
        equations.gradient.segment<6>(6 * index) += sign * weight * distance * J;
        equations.information.block<6, 6>(6 * index, 6 * index) += weight * J * J.transpose();
        if (extra == Extra::kRows && robust > 0)
          equations.rows.block<1, 6>(row, 6 * index) = sign * J.transpose();
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

bool run_icp(const IcpProblem& problem, std::span<const IcpLevel> levels, const FixedDirections& fixed,
             std::vector<Rigid3>& poses) {
  const auto unknowns = static_cast<Eigen::Index>(6 * problem.moving.size());
  const bool any_fixed = fixed.directions.size() > 0;
  assert(!any_fixed || fixed.directions.rows() == unknowns);
  for (const IcpLevel& level : levels) {
    for (int iteration = 0; iteration < level.iterations; ++iteration) {
      const NormalEquations equations =
          normal_equations(problem, poses, level, Extra::kNone, any_fixed ? &fixed.motions : nullptr);
      if (equations.matches < kFewestMatches) return false;
      Eigen::MatrixXd A = equations.information;
      A.diagonal().array() += 1e-6 * A.diagonal().maxCoeff();
      Eigen::VectorXd g = equations.gradient;
      if (any_fixed) {
        const Eigen::MatrixXd held = fixed.directions * fixed.directions.transpose();
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

namespace {

// Fitted normals have errors of a few degrees, so even a wall seems to determine motion along it.
// Parts below the squared sine of six degrees are ignored.
constexpr double kNoise = 0.01;

}  // namespace

Observability measure_observability(const NormalEquations& equations) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(equations.information);
  Observability out{solver.eigenvectors(), Eigen::VectorXd::Zero(equations.information.rows())};
  for (Eigen::Index column = 0; column < out.values.size(); ++column) {
    const Eigen::VectorXd direction = out.directions.col(column);
    double along_normals = 0, all = 0;
    for (Eigen::Index row = 0; row < equations.rows.rows(); ++row) {
      double motion = 0;  // Squared motion of the two cameras of this match.
      for (Eigen::Index camera = 0; camera < direction.size(); camera += 6) {
        if (equations.rows.block<1, 6>(row, camera).isZero(0)) continue;
        motion += direction.segment<6>(camera).squaredNorm();
      }
      const double along = equations.rows.row(row).dot(direction);
      along_normals += std::max(0.0, along * along - kNoise * motion);
      all += motion;
    }
    out.values[column] = all > 0 ? along_normals / all : 0;
  }
  return out;
}

}  // namespace copresence::calibrate
