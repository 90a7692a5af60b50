#pragma once

// Iterated closest points (ICP) for all cameras at once: moves cameras until their surfaces
// coincide. ICP minimises the sum of w rho(n * (p_a - p_b)) over all matches, where p_a and p_b are
// the matched points. The normal n is the mean of both points' normals, as in the symmetric
// point-to-plane distance (Rusinkiewicz 2019). The weight w comes from weight_of(). The function
// rho is Tukey's kernel, which is constant beyond a limit. The limit shrinks from level to level.
// Each iteration finds new matches and makes one Gauss-Newton step. Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/association.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

struct IcpLevel {
  double reach_m;  ///< Largest distance of a match.
  int spacing;     ///< Pixels between points.
  int iterations;
};

/// Side of a square block of pixels with similar errors. Averaging does not remove a Kinect's
/// systematic errors, which are similar in patches of this size. Blocks count as independent.
inline constexpr int kBlock_px = 48;

/// Selects blocks. White and black alternate like the squares of a chessboard, so that a fit to one
/// colour can be tested on the other.
enum class Blocks { kAll, kWhite, kBlack };

/// The cameras, which of them may move, and which pairs overlap.
struct IcpProblem {
  std::span<const Surface> surfaces;
  std::vector<std::size_t> moving;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  Blocks blocks = Blocks::kAll;
};

/// Parameters of small motions, six per moving camera: a rotation vector about `center`, then a
/// translation, in world axes. All are in metres: a rotation is the motion of a point at distance
/// `radius_m`.
struct Motions {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 1;

  Rigid3 moved(const Rigid3& pose, const Eigen::Matrix<double, 6, 1>& motion) const;
  /// Returns the motion from `from` to `to`; the inverse of moved().
  Eigen::Matrix<double, 6, 1> between(const Rigid3& from, const Rigid3& to) const;
};

/// The normal equations of the matches at given poses.
struct NormalEquations {
  Motions motions;
  Eigen::MatrixXd information;  ///< J^T W J, with the Jacobian J and the weights W.
  Eigen::VectorXd gradient;     ///< J^T W r, with the residuals r.
  /// Covariance of the gradient, from the residuals. Matches that share a block of a picture have
  /// dependent errors (Cameron and Miller 2014, dyadic clusters). So the covariance sums g g^T over
  /// all blocks, where g is the block's part of the gradient, and subtracts the terms that are
  /// counted twice. Set only with Extra::kScatter.
  Eigen::MatrixXd scatter;
  /// The Jacobian J, one row per match; 0 for matches without weight. Set only with Extra::kRows.
  Eigen::MatrixXd rows;
  /// The sum over the matches of w k^2 / 6 (1 - (r / k)^2)^3, with the weight w, the residual r and
  /// the limit k of Tukey's kernel. ICP maximises this score.
  double score = 0;
  std::vector<double> block_scores;  ///< The score of each block, pair by pair.
  int matches = 0;
};

/// Optional results that cost time or memory.
enum class Extra { kNone, kRows, kScatter };

/// `about` gives the centre and radius of the motions. If it is null, those of the matches are
/// used.
NormalEquations normal_equations(const IcpProblem& problem, std::span<const Rigid3> poses,
                                 const IcpLevel& level, Extra extra = Extra::kNone,
                                 const Motions* about = nullptr);

/// Directions in which no camera may move.
struct FixedDirections {
  /// Orthonormal columns, in the parameters of `motions`; may be empty.
  Eigen::MatrixXd directions;
  Motions motions;
};

/// Runs ICP on all levels. Returns false if there were too few matches.
bool run_icp(const IcpProblem& problem, std::span<const IcpLevel> levels, const FixedDirections& fixed,
             std::vector<Rigid3>& poses);

/// Tells how well the matches determine each direction of motion.
struct Observability {
  Eigen::MatrixXd directions;  ///< Orthonormal columns: motions of all moving cameras.
  Eigen::VectorXd values;      ///< Observability of each column; see Direction in refinement.h.
};

/// Requires equations with Extra::kRows.
Observability measure_observability(const NormalEquations& equations);

}  // namespace copresence::calibrate
