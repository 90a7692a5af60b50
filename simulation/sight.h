#pragma once

// Where the pixels of a camera look.
//
// Thread: a value.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"

namespace copresence::simulation {

struct Sight {
  /// Requires a model that check() accepts and a rigid pose.
  Sight(const CameraModel& model, const Rigid3& world_from_camera);

  std::size_t width() const { return static_cast<std::size_t>(model.width); }
  std::size_t height() const { return static_cast<std::size_t>(model.height); }

  /// From a pixel's middle and a place in it, in pixels from there.
  Eigen::Vector3f direction(std::size_t pixel, const Eigen::Vector2f& offset) const {
    return directions[pixel] + offset.x() * pixel_x + offset.y() * pixel_y;
  }

  CameraModel model;
  Rigid3 world_from_camera;
  Eigen::Vector3f eye;                      ///< metres, world frame
  std::vector<Eigen::Vector3f> directions;  ///< per pixel, world frame, length 1 along the optical axis
  Eigen::Vector3f pixel_x, pixel_y;         ///< change of direction from one pixel to the next
};

}  // namespace copresence::simulation
