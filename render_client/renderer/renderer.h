#pragma once

// The interface of both renderers: draws the newest frames of all cameras, merged, as seen from one
// pose.
//
// Each camera's depth image becomes a mesh without triangles across depth discontinuities. The
// meshes are drawn from the eye, and the drawings are merged pixel by pixel: of the fragments
// within the uncertainty range of the nearest one, those with the best quality index count (thesis
// 2.6.1). Both implementations follow renderer/merge_rules.h, and a test compares their pictures.
//
// Thread: one thread makes, uses and destroys a renderer.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "render_client/viewpoint/view_pose.h"

namespace copresence::renderer {

using viewpoint::ViewPose;

/// The most cameras that one view can show, in both renderers. Command line and scene file are
/// checked.
inline constexpr std::size_t kMostCameras = 32;

/// One camera as a renderer takes it.
struct CameraView {
  /// The newest frame. It must outlive the call. Its pose is not used.
  const RgbdFrame* frame = nullptr;
  /// Cache key: mesh and texture of a camera are reused while `version` is unchanged. So every
  /// frame, of any camera, must have a version of its own.
  std::uint64_t version = 0;
  CameraModel model;  ///< same size as the frame's images
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  Rigid3 world_from_camera;
  /// To the reference camera's colours, RGB 0 to 1.
  Eigen::Matrix<float, 3, 4> color_correction = Eigen::Matrix<float, 3, 4>::Identity();
  double calibration_error_m = 0.005;  ///< widens the uncertainty range
  /// 1 for a live camera. Below 1 the camera fades, because no new frame has come (merge_rules.h,
  /// Stale). 0: not drawn.
  float opacity = 1;
};

/// Where a pixel of a view comes from.
enum class Origin : std::uint8_t {
  kSeen,      ///< a fragment of a camera's newest frame
  kExtended,  ///< no camera has seen it: the farther surfaces around it are continued (extension_rules.h)
  kEmpty,     ///< outside all cameras' pictures, or there is nothing to continue
};

/// How pixels look that no camera has seen.
struct UnseenStyle {
  enum class Show {
    kExtend,  ///< continued surfaces in their colours
    kDim,     ///< at half of their brightness
    kBlack,   ///< not at all: all of them are kEmpty
  };
  Show show = Show::kBlack;
  Rgb8 background{0, 0, 0};  ///< colour of empty pixels

  float brightness() const { return show == Show::kDim ? 0.5F : 1.0F; }
};

/// Which part of a view's pixels has which origin; 0 to 1, together 1.
struct OriginShares {
  float seen = 0, extended = 0, empty = 1;
};

inline constexpr std::uint8_t kNoCamera = 255;  ///< in MergedView::camera if nothing is shown

/// Which images of a MergedView are filled.
struct HostPixels {
  bool color = false;
  bool depth = false;  ///< depth, camera, quality and origin
};

/// A view of the merged scene.
struct MergedView {
  /// Set by the caller. Pictures with different targets exist side by side: use one target for each
  /// eye. From 0 up.
  int target = 0;

  int width = 0;
  int height = 0;
  Image<Rgba8> color;          ///< the background with a = 0 if nothing is shown; empty unless wanted
  Image<float> depth_m;        ///< along the eye's axis; 0 if nothing is shown; empty unless wanted
  Image<std::uint8_t> camera;  ///< index of the camera that has the pixel; kNoCamera for none
  Image<float> quality;        ///< quality index of that camera, cos(theta) / z^2 (thesis eq. 2.5), 1/m^2
  Image<Origin> origin;
  /// Of the CPU renderer only: the GL renderer would have to wait for its pictures.
  std::optional<OriginShares> shares;
  /// OpenGL name of an RGBA8 texture with the colours, rows from the top. It holds the view until
  /// the next render() to the same target. 0 for the CPU renderer.
  std::uint32_t texture = 0;
};

class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual std::string_view name() const = 0;  ///< "cpu" or "gl", as in --renderer and the statistics

  /// How unseen pixels look from the next view on; kBlack on black before. Surfaces are continued only if the colour
  /// is wanted.
  virtual void set_unseen(const UnseenStyle& style) = 0;

  /// Makes meshes and textures of these cameras ahead. Call it while no view is due. The next
  /// render() may have newer frames or other cameras.
  virtual void prepare(std::span<const CameraView> cameras) = 0;

  /// Draws the cameras as seen from `eye`. MergedView::camera is an index into `cameras`. The
  /// number of cameras and their models may change between calls. The images of `view` keep their
  /// memory. A camera without colour is shaded by its surface normals. Requires at most
  /// kMostCameras. Fails only if the graphics driver does.
  virtual Result<void> render(std::span<const CameraView> cameras, const ViewPose& eye, HostPixels wanted,
                              MergedView& view) = 0;
};

}  // namespace copresence::renderer
