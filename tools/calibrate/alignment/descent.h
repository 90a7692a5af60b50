#pragma once

// Moves cameras until their surfaces lie on each other: iterated closest points, all cameras at once.
//
// Minimised is the sum over all matches of every pair of w rho(n (p_a - p_b)): n the mean of both points' normals
// (the symmetric form of point to plane, Rusinkiewicz 2019), w by expected error (weight_of()), rho Tukey's, which grows no more
// beyond a distance that shrinks from level to level. Each iteration matches anew and solves the normal equations of
// Gauss and Newton.
//
// Thread: pure.

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/matches.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::alignment {

struct Level {
  double reach_m;  ///< distance at which surfaces still count as the same
  int spacing;     ///< pixels between points
  int iterations;  ///< at most
};

/// A Kinect's depth is off in patches of about this size, however long it is averaged, and so is what a lens makes of it:
/// matches whose points lie in one block of a pair's first picture err together, those of different blocks do not.
inline constexpr int kBlock_px = 48;

/// The blocks may be dealt out like the squares of a chessboard, to fit on one colour and to judge on the other.
enum class Blocks { kAll, kWhite, kBlack };

/// Which cameras may move, and which pairs see something in common.
struct Problem {
  std::span<const Surface> surfaces;
  std::vector<std::size_t> moving;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  Blocks blocks = Blocks::kAll;
};

/// Small motions of all moving cameras, six numbers each (three of rotation, then three of translation), about one
/// centre and in metres: a rotation counts as the motion of points at `radius_m`.
struct Motions {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 1;

  Rigid3 moved(const Rigid3& pose, const Eigen::Matrix<double, 6, 1>& motion) const;
  /// The motion that takes `from` to `to`: the inverse of moved().
  Eigen::Matrix<double, 6, 1> between(const Rigid3& from, const Rigid3& to) const;
};

/// What the matches say about motions around given poses.
struct Equations {
  Motions motions;
  Eigen::MatrixXd information;  ///< J^T w J
  Eigen::VectorXd gradient;     ///< J^T w r
  /// What the matches' errors may have made of the gradient, squared. Two matches err together when they share a block of
  /// either camera's picture, in whichever pair: sum over all blocks of all cameras of g g^T, g what the block's matches
  /// add to the gradient, less what has so been counted twice (dyadic clusters; Cameron and Miller 2014). Only when asked for
  Eigen::MatrixXd scatter;
  Eigen::MatrixXd rows;  ///< J, a row per match; 0 where the match counts for nothing. Only when asked for
  /// What descend() raises: the sum over the matches of w k^2 / 6 (1 - (r / k)^2)^3, k where Tukey's kernel ends.
  double gain = 0;
  std::vector<double> block_gains;  ///< the same by block, pair after pair; 0 for one without matches
  int matches = 0;
};

/// What costs time or room and only some need.
enum class Extra { kNone, kRows, kScatter };

/// about  the centre and radius of the motions; the matches' own where it is null.
Equations linearize(const Problem& problem, std::span<const Rigid3> poses, const Level& level,
                    Extra extra = Extra::kNone, const Motions* about = nullptr);

/// Directions in which nothing may move.
struct Frozen {
  Eigen::MatrixXd
      directions;   ///< orthonormal columns, all moving cameras' numbers as in Equations; may be empty
  Motions motions;  ///< what the numbers mean
};

/// Descends through the levels. False when too few points ever met.
bool descend(const Problem& problem, std::span<const Level> levels, const Frozen& frozen,
             std::vector<Rigid3>& poses);

}  // namespace copresence::alignment
