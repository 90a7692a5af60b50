#include "render_client/renderer/merged_view.h"

#include <cmath>
#include <numbers>

namespace copresence::renderer {

CameraModel lens_from_fov(int width, int height, double fov_degrees) {
  CameraModel lens;
  lens.width = width;
  lens.height = height;
  lens.fy = 0.5 * height / std::tan(0.5 * fov_degrees * std::numbers::pi / 180.0);
  lens.fx = lens.fy;
  lens.cx = 0.5 * (width - 1);
  lens.cy = 0.5 * (height - 1);
  return lens;
}

}  // namespace copresence::renderer
