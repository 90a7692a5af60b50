#pragma once

// Holoimage (thesis 2.7.1 and equation 2.6): a virtual projector throws fringes onto the surface
// from the side, and a virtual camera takes a picture of it. Depth is triangulated from the
// fringes. Where the surface is in shadow of the projector, depth is lost.
// Projector and camera are orthographic. The depth image is a height field whose pixels are kPixelM
// apart. The projector stands to the right of the camera. A point at (x, z) has the fringe
// coordinate p = x cos(angle) + z sin(angle).
// The picture is YUV 4:4:4. U holds the sine of the phase of p, V holds the cosine, and Y holds the
// stair that counts whole fringes. Pixels without light are black. The thesis's equation uses RGB
// channels, but the thesis recommends YUV for H.264.

#include <vector>

#include "common/depth/depth_format.h"
#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::depth_bench {

/// Converts depth images to fringe pictures and back. Thread: one thread per object.
class Holoimage {
 public:
  static constexpr double kProjectorDegrees = 30;
  static constexpr double kPixelM = 0.0043;     ///< Width that a Kinect's pixel covers at 2.5 m.
  static constexpr double kFringeWidthM = 0.4;  ///< P in equation 2.6; corresponds to 0.8 m of depth.

  /// Requires a format that passes check().
  explicit Holoimage(const depth::DepthFormat& format);

  /// Requires an image of the format's size.
  Picture encode(const DepthImage& depth) const;

  /// Returns depth in the format's unit; 0 where the picture is black. Requires a picture of
  /// encode()'s format and size.
  void decode(const Picture& picture, DepthImage& depth) const;

  /// True for each pixel that has depth and that the projector reaches, row by row.
  std::vector<bool> find_lit_pixels(const DepthImage& depth) const;

 private:
  double fringe_coordinate(double x, double z) const;  // Takes x in pixels and z in the format's unit.

  depth::DepthFormat format_;
  double pixel_, sine_, cosine_;  // Pixel distance in the format's unit.
  // Fringe coordinate at which the first stair begins, and the width of a fringe, in the format's
  // unit.
  double first_, width_;
  double stair_;  // S in equation 2.6, from 0 to 255.
};

}  // namespace copresence::depth_bench
