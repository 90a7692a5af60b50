#pragma once

// Projective association of two cameras' surfaces: finds the points of both that are the same place
// in the room, and measures how well the surfaces agree there.
//
// Each point of one camera is projected into the other camera's picture and compared with the
// surface that is visible there. The comparison has one of three results:
//
//   Inlier: the other surface is less than 50 mm away and has a similar normal.
//   Violation: the point is in front of the other camera's surface and would hide it.
//   Not seen: the point is behind the other surface, outside of the picture, or at a hole.
//
// Thread: pure functions.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

struct Match {
  Eigen::Vector3d a, b;          ///< The matched points in the world frame, metres.
  Eigen::Vector3d normal;        ///< Mean of both normals, world frame, length 1.
  int pixel_a = 0, pixel_b = 0;  ///< The pixels of both points: y * width + x.
  double sigma = 0;              ///< Expected error of the distance along the normal, metres.
  double distance() const { return normal.dot(a - b); }
};

struct MatchRules {
  int spacing = 4;  ///< Pixels between the points that are projected.
  /// Largest distance along the target's normal, in addition to three sigmas.
  double reach_m = 0.05;
};

/// Appends the matches of points of `a` with the surface of `b`.
void append_matches(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                    const Rigid3& world_from_b, const MatchRules& rules, std::vector<Match>& matches);

inline constexpr double kSameSurface_m = 0.05;

/// How well two cameras' surfaces agree.
struct Agreement {
  /// Share of one camera's points that are inliers: the larger of both cameras' shares.
  double overlap = 0;
  double contradicted = 0;                   ///< Violations as a share of violations and inliers.
  double median_m = 0, p95_m = 0;            ///< Distance of the inliers along the normal.
  double median_sigmas = 0, p95_sigmas = 0;  ///< The distance in units of expected noise.
  double rms_m = 0;                          ///< RMS weighted by sigma; a violation counts as 50 mm.
  /// The sum of 1 - (distance / 50 mm)^2 over the inliers, minus the number of violations, divided
  /// by the number of points of both cameras. The better pose has the higher score.
  double score = 0;
  int points = 0;
};

/// `spacing` is the distance in pixels between the points that are projected.
Agreement measure_agreement(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                            const Rigid3& world_from_b, int spacing = 2);

enum class Association : std::uint8_t {
  kNone,
  kNotSeen,  ///< The point is behind, outside or at a hole; see above.
  kInlier,
  kViolation,
};

/// The association of every pixel of a camera, for pictures.
struct AssociationImage {
  Image<Association> association;
  Image<float> distance_m;  ///< Distance of inliers along the mean normal; positive in front of b's surface.
};
AssociationImage associate(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                           const Rigid3& world_from_b);

/// Weight of a point's squared distance: 1 / expected error (with a floor), not 1 / squared error.
/// Noise averages out over thousands of pixels. Errors of intrinsics, registration and depth
/// remain, and they grow less with distance. With the squared error, near points alone would
/// determine the pose.
double weight_of(double sigma_m);

}  // namespace copresence::calibrate
