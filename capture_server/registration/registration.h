#pragma once

// Brings depth and colour to one camera model, the depth camera's: colour is looked up where each depth
// pixel's point appears to the colour camera. Depth is never resampled, so the sensor's own levels, states
// and holes stay as they were measured (a codec of levels needs that) and a larger colour image costs nothing
// downstream.
//
// Where depth is already delivered as the colour camera sees it, or there is no colour, frames pass through
// untouched. Thread: one thread at a time per object.

#include <optional>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::registration {

/// How a sensor's two cameras stand to each other.
struct SensorCameras {
  CameraModel depth;                 ///< of the depth images as delivered
  std::optional<CameraModel> color;  ///< of the colour images; nothing where the sensor has none
  Rigid3 color_from_depth;           ///< metres; ignored where `registered`
  DepthUnit unit = DepthUnit::kMillimetre;
  bool registered = false;  ///< the driver delivers depth as seen by the colour camera
  DepthNoise noise = {};
};

class Registration {
 public:
  /// Fails (kInvalid) where a camera model or the transform is none.
  static Result<Registration> open(const SensorCameras& cameras);

  /// The camera of every frame that apply() returns, depth and colour.
  const CameraModel& model() const { return depth_; }

  /// Whether apply() hands frames on as they are.
  bool passes_through() const { return mapping_ == Mapping::kNone; }

  /// The frame with colour of the same shape and camera as its depth; depth and states as they came.
  ///
  /// A depth pixel that the colour camera cannot see (hidden behind something nearer, or outside its picture)
  /// takes the colour of the nearest pixel of its row that lies at a similar depth and can be seen. A hole is
  /// taken to lie on the farther of the surfaces beside it in its row, where an occlusion shadow belongs.
  /// Requires a depth image of model()'s size. Colour of another size than announced is dropped: the frame
  /// goes on without it. Source   thesis 3.1 (last part), eq. 2.1 to 2.4.
  RgbdFrame apply(RgbdFrame frame);

 private:
  enum class Mapping {
    kNone,   ///< pass-through
    kFixed,  ///< same viewpoint, other pixels: where colour lies does not depend on depth
    kDepth,  ///< another viewpoint
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
  int footprint_ = 2;  ///< pixels of the nearest-depth image that one depth pixel covers, each way

  // Per depth pixel, row by row: its ray turned into the colour camera, and where it appears there.
  std::vector<float> ray_x_, ray_y_, ray_z_;
  std::vector<float> u_, v_, z_;
  std::vector<float> row_z_;      ///< assumed depth of one row's pixels, metres
  std::vector<float> nearest_z_;  ///< what the colour camera sees, on a grid as large as the depth image
};

}  // namespace copresence::registration
