#pragma once

// Finds colours of extended surfaces in the cameras' pictures (extension_rules.h, Colour). Such
// surfaces have no depth in any camera. Examples are windows, screens, the shadow of a Kinect's
// projector, and thin lines along depth edges.
//
// Thread: one thread calls begin(). Then any number of threads may call find().

#include <Eigen/Core>
#include <span>
#include <vector>

#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/planar_blocks.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// Texture and inverse depth of one camera, with one element per pixel of the camera.
struct CameraPictures {
  const CameraTexture* texture;
  const InverseDepth* inverse;
};

class PictureColors {
 public:
  /// Eight colours, from 0 to 255. They are 0 where `found` is not set.
  struct Colors {
    Ints found;
    Floats r, g, b;
  };

  /// Prepares a view. `pictures[i]` belongs to `cameras[i]` and must outlive the last find().
  void begin(const ViewPose& eye, std::span<const CameraView> cameras,
             std::span<const CameraPictures> pictures);

  /// Returns the colours of surfaces at eight pixels of the view from (x, y) on, as far as they are
  /// `wanted` and a camera sees them. `w` are the surfaces' inverse depths along the eye's axis,
  /// 1/m. They are above 0 in the wanted lanes.
  Colors find(int x, int y, const Floats& w, const Ints& wanted) const;

  /// Returns false if find() finds nothing in the square of `size` pixels at (left, top), for
  /// surfaces near `w`. This quick test looks at whole cells of the cameras' pictures. It allows for
  /// the steepest surfaces that are extended.
  bool may_show(int left, int top, int size, float w) const;

 private:
  static constexpr int kCell = 16;
  static Image<float> farthest_cells(const InverseDepth& inverse);

  struct Camera {
    CameraPictures pictures;
    CameraModel model;
    bool is_distorted;
    Eigen::Vector2f focal, center, last;  // Of `model`; `last` is the last pixel.
    // A surface at pixel (x, y) of the view has the inverse depth w. In this camera's frame, its
    // point is rays * (x, y, 1) + w * origin, up to a factor.
    Eigen::Matrix3f rays;
    Eigen::Vector3f origin;
    // A pixel of the view covers this many pixels of the camera if both have the same distance.
    float pixels_per_pixel;
    // The smallest inverse depths of squares of kCell pixels a side. The value is 0 if a square has a
    // pixel without depth.
    Image<float> farthest;
    float opacity;

    // Returns the position of `ray` in the camera's picture. Requires ray.z() > 0.
    Eigen::Vector2f pixel(const Eigen::Vector3f& ray) const;
    // Returns whether a pixel of the picture within `radius` of `at` has at most the inverse depth
    // `nearest_visible`.
    bool has_farther(const Eigen::Vector2f& at, float radius, float nearest_visible) const;
  };

  std::vector<Camera> cameras_;
};

}  // namespace copresence::renderer
