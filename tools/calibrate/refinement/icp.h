#pragma once

// Iterated closest points (ICP) for all cameras at once: moves cameras until their surfaces
// coincide.
//
// It minimises the sum over all matches of all pairs of w rho(n (p_a - p_b)). n is the mean of both
// points' normals: the symmetric form of point-to-plane distance (Rusinkiewicz 2019). w is
// weight_of() the expected error. rho is Tukey's kernel, which is constant beyond a limit; the
// limit shrinks from level to level. Each iteration finds new matches and makes one Gauss-Newton
// step.
//
// Thread: pure.

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
  int spacing;     ///< pixels between points
  int iterations;  ///< at most
};

/// Side of a block of pixels whose errors are alike. Errors of a Kinect's depth and of intrinsics
/// are similar within patches of about this size, however long depth is averaged. Matches in
/// different blocks have independent errors.
inline constexpr int kBlock_px = 48;

/// The blocks to use. White and black alternate like the squares of a chessboard: a fit to one
/// colour is judged on the other.
enum class Blocks { kAll, kWhite, kBlack };

/// Which cameras may move, and which pairs of cameras overlap.
struct IcpProblem {
  std::span<const Surface> surfaces;
  std::vector<std::size_t> moving;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  Blocks blocks = Blocks::kAll;
};

/// Parameters of small motions, six per moving camera: a rotation vector about `center`, then a
/// translation, in world axes. All are in metres: a rotation counts as the motion of points at
/// `radius_m`.
struct Motions {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 1;

  Rigid3 moved(const Rigid3& pose, const Eigen::Matrix<double, 6, 1>& motion) const;
  /// The motion from `from` to `to`: the inverse of moved().
  Eigen::Matrix<double, 6, 1> between(const Rigid3& from, const Rigid3& to) const;
};

/// The normal equations of the matches at given poses.
struct NormalEquations {
  Motions motions;
  Eigen::MatrixXd information;  ///< J^T w J
  Eigen::VectorXd gradient;     ///< J^T w r
  /// Covariance of the gradient, from the residuals. Two matches have dependent errors if they
  /// share a block of either camera's picture, in any pair (dyadic clusters; Cameron and Miller
  /// 2014). So it is the sum of g g^T over all blocks of all cameras, where g is the block's part
  /// of the gradient, less what that counts twice. Only with Extra::kScatter.
  Eigen::MatrixXd scatter;
  Eigen::MatrixXd rows;  ///< J, one row per match; 0 for matches of no weight. Only with Extra::kRows.
  /// The sum over the matches of w k^2 / 6 (1 - (r / k)^2)^3, where k is the limit of Tukey's
  /// kernel. ICP maximises it.
  double score = 0;
  std::vector<double> block_scores;  ///< The score of each block, pair by pair.
  int matches = 0;
};

/// Results that cost time or memory, and that few callers need.
enum class Extra { kNone, kRows, kScatter };

/// about  centre and radius of the motions; if null, those of the matches.
NormalEquations normal_equations(const IcpProblem& problem, std::span<const Rigid3> poses,
                                 const IcpLevel& level, Extra extra = Extra::kNone,
                                 const Motions* about = nullptr);

/// Directions in which no camera may move.
struct FixedDirections {
  Eigen::MatrixXd directions;  ///< Orthonormal columns, in the parameters of `motions`; may be empty.
  Motions motions;
};

/// Runs all levels. False if there were too few matches.
bool run_icp(const IcpProblem& problem, std::span<const IcpLevel> levels, const FixedDirections& fixed,
             std::vector<Rigid3>& poses);

/// How well the matches determine each direction of motion.
struct Observability {
  Eigen::MatrixXd directions;  ///< Orthonormal columns: motions of all moving cameras.
  Eigen::VectorXd values;      ///< Of each column; see Direction in refinement.h.
};

/// Requires equations with rows.
Observability measure_observability(const NormalEquations& equations);

}  // namespace copresence::calibrate
