#pragma once

// A marker as a picture shows it, whoever found it: OpenCV, or a person with a mouse.

#include <Eigen/Core>
#include <string>
#include <vector>

namespace copresence::calibrate {

struct FoundMarker {
  std::string name;
  Eigen::Vector2d middle{0, 0};  ///< pixels
  std::vector<Eigen::Vector2d>
      corners;             ///< pixels, clockwise from the marker's own top left; empty where clicked
  double sigma_px = 0.25;  ///< standard deviation to expect of each coordinate
};

}  // namespace copresence::calibrate
