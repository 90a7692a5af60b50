#pragma once

// The world "markers": a bare room with calibration markers in it, so that calibration can be tried from picture to pose.
//
// The markers are those of OpenCV's dictionary DICT_4X4_50. Six hang at different heights and distances and face -z,
// where cameras 0 and 1 stand; their backs carry six others for cameras 2 and 3; four lie on boxes, for all to see.

#include <Eigen/Core>
#include <vector>

#include "simulation/furnishing.h"

namespace copresence::simulation {

/// One marker's black square: center +- half_u +- half_v, u to the right and v down as one looks at it. Metres, world.
struct PlacedMarker {
  int id = 0;
  Eigen::Vector3f center, half_u, half_v;
};

std::vector<PlacedMarker> placed_markers();

Furnishing furnish_markers();

/// The same room with nothing in it.
Furnishing furnish_bare_room();

}  // namespace copresence::simulation
