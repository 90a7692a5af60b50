#pragma once

// How well two cameras' surfaces agree, given where the cameras stand.
//
// Of each camera's points those are looked at that appear in the other's picture where that one measured depth:
//
//   meets      within 50 mm of the other's surface, the normals alike: the same surface
//   contradicts  nearer to the other camera than what it sees there, by more: it looks through the point
//   hidden     farther than what the other camera sees there: says nothing
//
// Thread: pure.

#include <cstdint>

#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::alignment {

inline constexpr double kSameSurface_m = 0.05;

struct Agreement {
  double overlap =
      0;  ///< share of one camera's points that meet the other's surface; the larger of both ways
  double contradicted = 0;                   ///< contradictions as a share of contradictions and meetings
  double median_m = 0, p95_m = 0;            ///< of the distance along the normal, where surfaces meet
  double median_sigmas = 0, p95_sigmas = 0;  ///< the same in units of what the sensors' noise leads to expect
  double rms_m = 0;  ///< of distances weighted by sigma, a contradiction counting 50 mm
  /// Sum over meetings of 1 - (distance / 50 mm)^2, less contradictions, as a share of both cameras' points: what
  /// tells a better pose from a worse one.
  double support = 0;
  int points = 0;  ///< meetings
};

/// What becomes of one camera's point in the other's picture.
enum class Meeting : std::uint8_t {
  kNone,    ///< no surface to look for
  kUnseen,  ///< outside of the other's picture, hidden from it, or it measured nothing there
  kMeets,
  kContradicts,
};

/// The same for every pixel of a, to look at.
struct Meetings {
  Image<Meeting> meeting;
  Image<float> distance_m;  ///< along the normals' mean, positive before b's surface; where it meets
};
Meetings find_meetings(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                       const Rigid3& world_from_b);

/// spacing  pixels between the points looked at.
Agreement measure_agreement(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                            const Rigid3& world_from_b, int spacing = 2);

/// What a point's squared distance weighs: one over its expected error (with a floor), not over its square. Over
/// thousands of pixels noise averages out; what stays, of lenses, registration and the bend of a sensor's depth, grows
/// less with distance, and a fit that trusted near points alone would lever the far ones about.
double weight_of(double sigma_m);

}  // namespace copresence::alignment
