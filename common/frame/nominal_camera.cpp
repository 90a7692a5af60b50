#include "common/frame/nominal_camera.h"

#include <algorithm>
#include <cmath>

namespace copresence {

CameraModel nominal_kinect(int width, int height) {
  constexpr double kLongerSide = 1.0144686;  // radians
  const double focal = 0.5 * std::max(width, height) / std::tan(0.5 * kLongerSide);
  return camera_from_field_of_view(width, height, 2 * std::atan(0.5 * height / focal));
}

CameraModel camera_of_sensor(int width, int height, double horizontal, double vertical) {
  constexpr double kMostOutOfSquare = 0.05;
  CameraModel camera = camera_from_field_of_view(width, height, horizontal, vertical);
  if (std::abs(camera.fx / camera.fy - 1) > kMostOutOfSquare) {
    const double focal = width >= height ? camera.fx : camera.fy;
    camera.fx = camera.fy = focal;
  }
  return camera;
}

}  // namespace copresence
