#pragma once

// Brings depth and colour to one camera model, the depth camera's. The colour of each depth pixel
// is looked up where its point appears in the colour camera. Depth is never resampled: levels,
// states and holes stay as they were measured, as depth codecs require.
//
// Frames pass unchanged without colour, or if the driver registers depth to colour.
//
// Thread: one thread at a time per object.

#include <optional>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::registration {

/// The cameras of a sensor and their relative pose.
struct SensorCameras {
  CameraModel depth;  ///< The camera of the depth images as delivered.
  /// The camera of the colour images. Nothing if the sensor has no colour.
  std::optional<CameraModel> color;
  Rigid3 color_from_depth;  ///< In metres. Ignored if `registered`.
  DepthUnit unit = DepthUnit::kMillimetre;
  bool registered = false;  ///< The driver delivers depth as seen by the colour camera.
  DepthNoise noise = {};
};

class Registration {
 public:
  /// Fails with kInvalid if a camera model or the transform is invalid.
  static Result<Registration> open(const SensorCameras& cameras);

  /// The camera model of depth and colour in every frame that apply() returns.
  const CameraModel& model() const { return depth_; }

  /// True if apply() returns frames unchanged.
  bool passes_through() const { return mapping_ == Mapping::kNone; }

  /// Returns the frame with colour of the same size and camera model as its depth. Depth and states
  /// are unchanged. Requires a depth image of model()'s size. Colour of another size is dropped.
  ///
  /// The colour camera cannot see a pixel that lies outside its picture or behind something nearer.
  /// The pixel then takes the colour of the nearest visible pixel of its row at a similar depth. A
  /// hole is assumed to lie on the farther of the surfaces next to it in its row.
  /// Source: thesis section 3.1 (last part), equations 2.1 to 2.4.
  RgbdFrame apply(RgbdFrame frame);

 private:
  enum class Mapping {
    kNone,   ///< Frames pass unchanged.
    kFixed,  ///< Both cameras have one viewpoint, so the lookup does not depend on depth.
    kDepth,  ///< The cameras have different viewpoints.
  };

  Registration() = default;
  void map_row(const RgbdFrame& frame, int y);
  void splat_row(const RgbdFrame& frame, int y);
  void color_row(const ColorImage& from, int y, std::span<Rgb8> to);
  bool is_visible(std::size_t at) const;

  Mapping mapping_ = Mapping::kNone;
  CameraModel depth_, color_;
  bool has_color_ = false;
  float metres_per_unit_ = 0.001f;
  DepthNoise noise_;
  Eigen::Vector3f translation_{0, 0, 0};
  /// Size of one depth pixel in the nearest-depth image: width and height in pixels.
  int footprint_ = 2;

  // Per depth pixel: its ray in the colour camera's frame and its position in the colour picture.
  std::vector<float> ray_x_, ray_y_, ray_z_;
  std::vector<float> u_, v_, z_;
  std::vector<float> row_z_;  ///< Assumed depths of one row in metres.
  /// Nearest depths seen by the colour camera, on a grid as large as the depth image.
  std::vector<float> nearest_z_;
};

}  // namespace copresence::registration
