#pragma once

// Refines where cameras stand on the surfaces that they see in common. The first camera stays where it is.
//
// Cameras are placed one after the other, each beside those that it shares most with: from its given pose and from
// poses around it, coarsely; the start that ends with the most support (agreement.h) is followed up finely. Then all
// move together. Directions that no matched surface resists, such as along a single wall, keep the given pose, and
// a result that agrees worse than the given poses, by more than chance, is thrown away.
//
// Thread: pure; the same input gives the same output.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/agreement.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::alignment {

inline constexpr double kLeastOverlap = 0.10;  ///< share of points below which a pair of cameras says nothing
inline constexpr double kLeastResistance = 0.01;  ///< see Direction

/// A motion of one camera that the matched surfaces resist least, of length 1.
struct Direction {
  Eigen::Vector3d turn;   ///< axis through the overlap's middle, world; in metres of motion at its radius
  Eigen::Vector3d shift;  ///< world
  /// Mean over the matches of the squared part of a motion of length 1 that goes along their normals, less what the
  /// normals' noise makes of none: 1/3 in a room's corner, 0 along a wall.
  double resistance = 0;
};

struct CameraRefinement {
  enum class Outcome {
    kReference,  ///< the first camera: never moved
    kRefined,
    kKept,         ///< the given pose agrees better, and not by chance
    kKnownBetter,  ///< kept: its error is told, and the surfaces tell the pose no better
    kNotConfirmed,  ///< kept: its error is told, and surfaces left out of the fit agree no better by more than chance
    kNoOverlap,  ///< too little in common with the cameras placed before it: not moved
  };
  Outcome outcome = Outcome::kReference;
  Rigid3 world_from_camera;
  double moved_mm = 0, moved_deg = 0;
  // Shifts of points in the volume that is seen in common, root mean square; 0 where unknown.
  double told_mm = 0;      ///< expected of the given pose, as told
  double surfaces_mm = 0;  ///< of what the surfaces alone say, by how they disagree from place to place
  double error_mm = 0;     ///< of the pose here
  bool contradicts_told = false;  ///< the surfaces lie farther from the given pose than both errors explain
  std::vector<Direction> unsupported;  ///< in these it kept its given pose
};

struct PairRefinement {
  std::size_t a = 0, b = 0;
  Agreement before, after;
};

struct Refinement {
  std::vector<CameraRefinement> cameras;
  std::vector<PairRefinement> pairs;  ///< every pair with something in common, before or after
  double least_resistance = 0;        ///< of all directions of all cameras that moved
};

/// surfaces  one per camera. Requires as many poses and errors, at least one.
/// poses     world_from_camera as given.
/// errors_m  what is known of the given poses: how far off points are in the shared volume, root mean square, as
///           `calibrate markers` says; 0 where nobody knows. A known error is weighed against what the surfaces tell,
///           see weighing.h: the pose is kept unless they clearly know better.
Refinement refine(std::span<const Surface> surfaces, std::span<const Rigid3> poses,
                  std::span<const double> errors_m);

}  // namespace copresence::alignment
