#include "render_client/renderer/merged_view.h"

#include <numbers>

namespace copresence::renderer {

CameraModel lens_from_fov(int width, int height, double fov_degrees) {
  return camera_from_field_of_view(width, height, fov_degrees * std::numbers::pi / 180.0);
}

}  // namespace copresence::renderer
