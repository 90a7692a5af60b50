#pragma once

// Refines the poses of cameras on the surfaces that they see in common. The first camera does not
// move.
//
// Cameras are placed one after the other, beside those that they share most with. Each starts
// coarsely from its given pose and from poses around it. The starts with the highest scores
// (Agreement::score) are refined finely. Then all cameras move together. Directions that no surface
// determines, such as along a single wall, keep the given pose. A result that agrees worse than the
// given poses, by more than chance, is discarded.
//
// Thread: pure; the same input gives the same output.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/association.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

inline constexpr double kLeastOverlap = 0.10;        ///< Share of common points that a pair of cameras needs.
inline constexpr double kLeastObservability = 0.01;  ///< see Direction

/// A motion of one camera that the surfaces do not determine, of length 1.
struct Direction {
  Eigen::Vector3d turn;   ///< Rotation vector, world; in metres of motion at the overlap's radius.
  Eigen::Vector3d shift;  ///< world
  /// Mean over the matches of the squared part of the motion along their normals, less the effect
  /// of the normals' noise: 1/3 in the corner of a room, 0 along a wall.
  double observability = 0;
};

struct CameraRefinement {
  enum class Outcome {
    kReference,  ///< The first camera, which never moves.
    kRefined,
    kKept,          ///< Not moved: the surfaces agree better at the given pose, by more than chance.
    kPriorBetter,   ///< Not moved: the surfaces are not more accurate than the pose's known error.
    kNotConfirmed,  ///< Not moved: surfaces left out of the fit do not agree better than by chance.
    kNoOverlap,     ///< Not moved: too little in common with the cameras placed before it.
  };
  Outcome outcome = Outcome::kReference;
  Rigid3 world_from_camera;
  double moved_mm = 0, moved_deg = 0;
  // Root mean square shifts of points in the shared volume; 0 if unknown.
  double prior_mm = 0;     ///< Error of the given pose, as given.
  double surfaces_mm = 0;  ///< Error of the surfaces alone, by their residuals.
  double error_mm = 0;     ///< Expected error of the refined pose.
  /// The surfaces disagree with the given pose by more than both errors explain.
  bool contradicts_prior = false;
  std::vector<Direction> unobservable;  ///< Directions in which it keeps the given pose.
};

struct PairRefinement {
  std::size_t a = 0, b = 0;
  Agreement before, after;
};

struct Refinement {
  std::vector<CameraRefinement> cameras;
  std::vector<PairRefinement> pairs;  ///< All pairs that overlap before or after.
  double least_observability = 0;     ///< The smallest over all directions of all moving cameras.
};

/// surfaces  one per camera. Requires as many poses and errors, at least one.
/// poses     world_from_camera as given.
/// errors_m  known errors of the given poses: root mean square shift of points in the shared
///           volume, as `calibrate markers` estimates it; 0 if unknown. A pose with a known error
///           moves only if the surfaces are clearly more accurate; see prior_fusion.h.
Refinement refine(std::span<const Surface> surfaces, std::span<const Rigid3> poses,
                  std::span<const double> errors_m);

}  // namespace copresence::calibrate
