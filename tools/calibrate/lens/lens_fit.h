#pragma once

// A lens from views of a board: focal lengths, principal point and OpenCV's rational distortion (thesis 2.5.1, eq. 2.4),
// and where two cameras stand to each other that see one board at the same time (2.5.2). Thread: pure functions.

#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/lens/board.h"

namespace copresence::calibrate {

struct ViewFit {
  std::string picture;
  double rms_px = 0;         ///< reprojection error
  Rigid3 camera_from_board;  ///< metres
};

struct LensFit {
  CameraModel model;
  std::string distortion;            ///< the coefficients that the views can tell; the others are 0
  double rms_px = 0;                 ///< over all views
  double focal_sigma_px = 0;         ///< standard deviation of fx or fy, the larger, as OpenCV estimates it
  double center_sigma_px = 0;        ///< of cx and cy, the larger
  double covered = 0;                ///< share of the picture's 8 x 6 fields that a corner fell into
  std::vector<ViewFit> views;        ///< those used
  std::vector<DroppedView> dropped;  ///< those that fit three times worse than the median
};

inline constexpr std::size_t kFewestViews = 6;

/// What a fit must reach. Pixel errors are for pictures up to kUsualWidth wide and grow in proportion above.
inline constexpr double kGoodRmsPx = 0.3, kMostRmsPx = 1.0, kUsualWidth = 1280;
/// The largest standard deviations: of a focal length as a share of itself, of the principal point as a share of the
/// picture's longer side.
inline constexpr double kMostFocalSigma = 0.01, kMostCenterSigma = 0.01;

/// rms_px in units of kGoodRmsPx, at the picture's size: 1 and less is good.
double times_good_rms(const LensFit& fit);

/// Fails  kInvalid: fewer than kFewestViews views, or an error or uncertainty above the limits; says the likely cause:
///        views of two cameras, a board that is hardly tilted or small, a wrong board size, a fisheye lens.
Result<LensFit> fit_lens(std::span<const BoardView> views, int width, int height);

/// Where the board is, for a known lens. Fails  kInvalid where the corners lie too badly to tell.
Result<ViewFit> locate_board(const BoardView& view, const CameraModel& model);

}  // namespace copresence::calibrate
