#pragma once

// Measures the difference of rendered views from the ground truth, over all reachable pixels. A
// pixel is reachable if its true surface point lies in the image and depth range of a camera.
// Another object may hide the point from that camera. Pixels that show nothing count as black.
// Thread: one thread per object.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "render_client/renderer/renderer.h"
#include "simulation/truth/true_camera.h"

namespace copresence::view_bench {

struct ViewVolume {
  CameraModel model;
  Rigid3 world_from_camera;
  DepthRange range;
  /// The farthest depth that each pixel has ever measured, in metres; 0 for none. Null if unknown.
  const Image<float>* farthest_m = nullptr;
};

/// The ground truth at the viewpoint, and masks that the metrics need.
struct TrueEyeView {
  ColorImage color;
  Image<float> depth_m;
  Image<std::uint8_t> reachable;      ///< Is 1 if a camera could have shown the surface.
  Image<std::uint8_t> ever_seen;      ///< Is 1 if a camera has ever measured the surface.
  Image<std::uint8_t> at_silhouette;  ///< Is 1 within kSilhouettePixels of a depth edge.
  Image<std::uint8_t> is_flat;        ///< Is 1 where depth and colour are smooth within kSeamPixels.
  /// Is 1 where something moves, see moving_region(). It may be empty if nothing moves.
  Image<std::uint8_t> is_moving;
};

inline constexpr int kSilhouettePixels = 12;
inline constexpr int kSeamPixels = 3;
inline constexpr int kMovingPixels = 6;

TrueEyeView describe_truth(const simulation::TrueView& truth, const renderer::ViewPose& eye,
                           std::span<const ViewVolume> cameras);

/// Returns 1 within kMovingPixels of each pixel that shows another surface than `earlier_m`, the true
/// depth of an earlier instant. Requires equal sizes.
Image<std::uint8_t> moving_region(const Image<float>& depth_m, const Image<float>& earlier_m);

/// One scene's result: PSNR in dB, shares in percent of reachable pixels, differences in 1/255.
struct ViewScore {
  double seen_percent = 0, remembered_percent = 0, extended_percent = 0, empty_percent = 0;
  /// Share of remembered pixels among those that a camera saw earlier and none sees now.
  double recalled_percent = 0;
  double psnr = 0;       ///< PSNR over all reachable pixels.
  double psnr_seen = 0;  ///< PSNR over pixels that a camera sees.
  /// PSNR over pixels that show a remembered background; NaN if there are none.
  double psnr_remembered = 0;
  /// PSNR over pixels that show an extended surface; NaN if there are none.
  double psnr_extended = 0;
  double psnr_silhouette = 0;  ///< PSNR over pixels near depth edges.
  double psnr_moving = 0;      ///< PSNR over pixels of moving regions; NaN if nothing moves.
  /// Mean change of shown pixels between consecutive views, where the ground truth does not change.
  double flicker = 0;
  /// Mean change as above, over pixels that both views show as remembered or extended surfaces.
  double flicker_remembered = 0, flicker_extended = 0;
  /// Mean step across borders between cameras on flat surfaces, less that of the ground truth. Only
  /// seen pixels with the true depth count. NaN if there are no such borders.
  double seam_step = 0;
  double sharpness = 0;  ///< Variance of the Laplacian, as a share of the ground truth's.
  int views = 0;
};

/// Computes the errors of the views of one scene.
class ViewError {
 public:
  /// Adds a view with colour, depth and camera images. Requires equal sizes. Set `is_next` if the
  /// view before had the same viewpoint one frame earlier, so that flicker can be measured.
  void add(const TrueEyeView& truth, const renderer::MergedView& view, bool is_next);

  ViewScore score() const;

 private:
  struct Squares {
    double sum = 0;
    std::uint64_t samples = 0;
    double psnr() const;
  };

  void add_seams(const TrueEyeView& truth, const renderer::MergedView& view);
  void add_flicker(const TrueEyeView& truth, const renderer::MergedView& view);
  void add_sharpness(const TrueEyeView& truth, const renderer::MergedView& view);

  struct Mean {
    double sum = 0;
    std::uint64_t samples = 0;
    void add(double value);
    double value() const;
  };

  Squares all_, seen_, remembered_, extended_, silhouette_, moving_;
  Mean flicker_, flicker_remembered_, flicker_extended_, seams_, recalled_;
  double laplacian_ = 0, true_laplacian_ = 0;
  int views_ = 0;
  Image<Rgba8> last_color_;
  Image<renderer::Origin> last_origin_;
  ColorImage last_truth_;
};

}  // namespace copresence::view_bench
