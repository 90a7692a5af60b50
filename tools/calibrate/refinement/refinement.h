#pragma once

// Refines the poses of cameras on the surfaces that they see in common. The first camera does not
// move.
// Cameras are placed one after the other, each next to the cameras with which its surfaces overlap
// most. Each camera is first aligned coarsely, starting from its given pose and from poses around
// it. The results with the highest scores (Agreement::score) are refined finely. Then all cameras
// move together. Directions that no surface determines, such as along a single wall, keep the given
// pose. A result that agrees worse than the given poses, by more than chance, is discarded. Thread:
// pure functions; the same input gives the same output.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/association.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

inline constexpr double kLeastOverlap = 0.10;        ///< Minimum share of common points in a pair of cameras.
inline constexpr double kLeastObservability = 0.01;  ///< Minimum value of Direction::observability.

/// A motion of one camera that the surfaces do not determine, of length 1.
struct Direction {
  Eigen::Vector3d turn;   ///< Rotation vector in the world frame, times the overlap's radius, in metres.
  Eigen::Vector3d shift;  ///< Translation, world frame.
  /// Mean over the matches of the squared normal component of the motion, corrected for noise of
  /// the normals. The value is 1/3 in the corner of a room and 0 along a wall.
  double observability = 0;
};

struct CameraRefinement {
  enum class Outcome {
    kReference,  ///< The first camera, which never moves.
    kRefined,
    kKept,          ///< Not moved: the surfaces agree better at the given pose.
    kPriorBetter,   ///< Not moved: the surfaces are not more accurate than the given pose.
    kNotConfirmed,  ///< Not moved: surfaces left out of the fit agree no better.
    kNoOverlap,     ///< Not moved: the camera overlaps too little with those placed before.
  };
  Outcome outcome = Outcome::kReference;
  Rigid3 world_from_camera;
  double moved_mm = 0, moved_deg = 0;
  // Root mean square shifts of points in the shared volume; 0 if unknown.
  double prior_mm = 0;     ///< Error of the given pose, from the caller.
  double surfaces_mm = 0;  ///< Error of the surfaces alone, by their residuals.
  double error_mm = 0;     ///< Expected error of the refined pose.
  /// True if the surfaces differ from the given pose by more than both errors explain.
  bool contradicts_prior = false;
  std::vector<Direction> unobservable;  ///< Directions that keep the given pose.
};

struct PairRefinement {
  std::size_t a = 0, b = 0;
  Agreement before, after;
};

struct Refinement {
  std::vector<CameraRefinement> cameras;
  std::vector<PairRefinement> pairs;  ///< Pairs that overlap before or after refinement.
  double least_observability = 0;     ///< Smallest observability of all motions of all cameras.
};

/// `surfaces` has one element per camera, at least one. Requires as many poses and errors.
/// `poses` are the given poses world_from_camera.
/// `errors_m` are the known errors of the given poses: root mean square shift of points in the
/// shared volume, as `calibrate markers` estimates it; 0 if unknown. A pose with a known error
/// moves only if the surfaces are clearly more accurate; see prior_fusion.h.
Refinement refine(std::span<const Surface> surfaces, std::span<const Rigid3> poses,
                  std::span<const double> errors_m);

}  // namespace copresence::calibrate
