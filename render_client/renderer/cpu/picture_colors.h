#pragma once

// Colours of surfaces that have no depth in any camera, taken from the cameras' pictures
// (extension_rules.h, Colour): windows, screens, the shadow of a Kinect's projector, and hairlines
// along depth edges.
//
// Thread: begin() by one thread; then find() by any number of threads.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/planar_blocks.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// The pictures of one camera, in its own pixels.
struct CameraPictures {
  const CameraTexture* texture;
  const InverseDepth* inverse;
};

class PictureColors {
 public:
  struct Color {
    float r, g, b;  ///< 0 to 255
  };

  /// Prepares a view. `pictures[i]` belongs to `cameras[i]`, and must outlive the last find().
  void begin(const ViewPose& eye, std::span<const CameraView> cameras,
             std::span<const CameraPictures> pictures);

  /// The colour of the surface that the view's pixel (x, y) shows at inverse depth `w` > 0 along the
  /// eye's axis, 1/m. Nothing if no camera sees it.
  std::optional<Color> find(int x, int y, float w) const;

 private:
  struct Camera {
    CameraPictures pictures;
    CameraModel model;
    bool is_distorted;
    Eigen::Vector2f focal, center, last;  // Of `model`; `last` is the last pixel.
    // A point at pixel (x, y) of the view with inverse depth w is rays * (x, y, 1) + w * origin in
    // this camera's frame, up to a factor.
    Eigen::Matrix3f rays;
    Eigen::Vector3f origin;
    float opacity;

    // The pixel that shows the direction of `ray`. Requires ray.z() > 0.
    Eigen::Vector2f pixel(const Eigen::Vector3f& ray) const;
  };

  std::vector<Camera> cameras_;
};

}  // namespace copresence::renderer
