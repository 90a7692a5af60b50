#pragma once

// What a simulated Kinect has of a view before anything random: the same whenever it sees that view.
//
// Thread: a value.

#include "simulation/color_response.h"
#include "simulation/projected_dots.h"

namespace copresence::simulation {

struct SensedView {
  DotImage dots;
  SensedColors colors;
};

}  // namespace copresence::simulation
