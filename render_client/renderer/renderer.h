#pragma once

// The interface of both renderers. A renderer merges the newest frames of all cameras into a view.
//
// Each camera's depth image becomes a mesh without triangles across depth discontinuities. The
// meshes are drawn from the eye's pose, and the drawings are merged pixel by pixel. Among the
// fragments within the uncertainty range of the nearest, those with the best quality index are
// shown (thesis 2.6.1). Both renderers follow renderer/merge_rules.h, and a test compares their
// pictures. Thread: one thread makes, uses and destroys a renderer.

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
#include "render_client/renderer/merge_rules.h"
#include "render_client/viewpoint/view_pose.h"

namespace copresence::renderer {

using viewpoint::ViewPose;

/// A view can show at most this many cameras. The program checks its command line and scene file.
inline constexpr std::size_t kMostCameras = 32;
/// Maximum number of elements of `cameras` in Renderer::render(): each camera's newest frame and
/// its remembered background.
inline constexpr std::size_t kMostViews = 2 * kMostCameras;

/// One camera as input of a renderer.
struct CameraView {
  /// The newest frame. It must outlive the call. The frame's own pose is not used. Pixels without
  /// depth whose state is not kHole are left out (merge_rules.h).
  const RgbdFrame* frame = nullptr;
  /// Mesh and texture of a camera are reused while `version` is unchanged. It must be unique over
  /// the frames of all cameras.
  std::uint64_t version = 0;
  CameraModel model;  ///< It has the size of the frame's images.
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  Rigid3 world_from_camera;
  /// Maps the camera's colours to the reference camera's colours, RGB 0 to 1.
  Eigen::Matrix<float, 3, 4> color_correction = Eigen::Matrix<float, 3, 4>::Identity();
  double calibration_error_m = 0.005;  ///< Expected error of the camera's pose.
  /// Opacity: 1 for a live camera, less for a stale one that sends no frames (merge_rules.h,
  /// Stale). A camera with opacity 0 is not drawn.
  float opacity = 1;
  /// If true, `frame` is a remembered background: surfaces that the camera saw earlier and that
  /// something hides now. It is drawn only where no camera's newest frame shows anything
  /// (merge_rules.h, Remembered).
  bool is_remembered = false;
};

/// The origin of a pixel of a view.
enum class Origin : std::uint8_t {
  kSeen,        ///< A camera's newest frame shows this point.
  kRemembered,  ///< A camera saw this point earlier, and something covers it now.
  kExtended,    ///< No camera shows it. A surface beside it was extended (extension_rules.h).
  kEmpty,       ///< No camera shows it, and no surface was extended to it.
};

/// Selects the look of pixels that no camera sees now.
struct UnseenStyle {
  enum class Show {
    kExtend,  ///< Shows remembered backgrounds, and extends the surfaces around other pixels.
    kDim,     ///< As kExtend, at half of the brightness.
    kBlack,   ///< All unseen pixels are kEmpty.
  };
  Show show = Show::kBlack;
  Rgb8 background{0, 0, 0};  ///< Colour of empty pixels.

  float brightness() const { return show == Show::kDim ? 0.5F : 1.0F; }
};

/// Whether a renderer draws the camera in this style.
inline bool is_drawn(const CameraView& camera, const UnseenStyle& style) {
  return camera.opacity > 0 && !(camera.is_remembered && style.show == UnseenStyle::Show::kBlack);
}

/// Fractions of a view's pixels by origin. Their sum is 1.
struct OriginShares {
  float seen = 0, remembered = 0, extended = 0, empty = 1;
};

inline constexpr std::uint8_t kNoCamera = 255;  ///< MergedView::camera of empty pixels.

/// Selects the images of a MergedView to fill.
struct HostPixels {
  bool color = false;
  bool depth = false;  ///< Also selects camera, quality and origin.
};

struct MergedView {
  /// The caller sets it and numbers the targets from 0. The pictures of different targets exist at
  /// the same time. Use one target for each eye.
  int target = 0;

  int width = 0;
  int height = 0;
  // Images that are not wanted are empty.
  Image<Rgba8> color;          ///< Alpha is 0 where the background is shown.
  Image<float> depth_m;        ///< Depth along the eye's axis; 0 where nothing is shown.
  Image<std::uint8_t> camera;  ///< Index of the camera that a pixel is from, or kNoCamera.
  Image<float> quality;        ///< The quality_index() of that camera's fragment, 1/m^2.
  Image<Origin> origin;
  /// Set by the CPU renderer only: the GL renderer would have to wait for its pictures.
  std::optional<OriginShares> shares;
  /// OpenGL name of an RGBA8 texture with the colours, first row at the top. It is valid until the
  /// next render() with the same target. It is 0 for the CPU renderer.
  std::uint32_t texture = 0;
};

class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual std::string_view name() const = 0;  ///< Returns "cpu" or "gl", as in --renderer.

  /// Sets how unseen pixels look from the next view on. The default is kBlack with a black
  /// background. Surfaces are extended only if the colour is wanted.
  virtual void set_unseen(const UnseenStyle& style) = 0;

  /// Sets how fragments are merged from the next view on. The default is kBlend.
  virtual void set_merge(MergeMode mode) = 0;

  /// Sets whether only the sides of the meshes' triangles are drawn. Returns whether the renderer can
  /// do this. The pixels between them count as unseen.
  virtual bool set_wireframe(bool wireframe) = 0;

  /// Makes meshes and textures of these cameras in advance. Call it while no view is due. The next
  /// render() may get newer frames or other cameras.
  virtual void prepare(std::span<const CameraView> cameras) = 0;

  /// Draws the cameras as seen from `eye`. MergedView::camera is an index into `cameras`. The
  /// number of cameras and their models may change between calls. The memory of the images of
  /// `view` is reused. A camera without colour is shaded by its surface normals. Requires at most
  /// kMostViews cameras. Fails only if the graphics driver fails.
  virtual Result<void> render(std::span<const CameraView> cameras, const ViewPose& eye, HostPixels wanted,
                              MergedView& view) = 0;
};

}  // namespace copresence::renderer
