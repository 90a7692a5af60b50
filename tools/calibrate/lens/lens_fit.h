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
  std::string distortion;            ///< the coefficients that the views could tell; the others are 0
  double rms_px = 0;                 ///< over all views
  double focal_sigma_px = 0;         ///< standard deviation of fx, as OpenCV estimates it
  double center_sigma_px = 0;        ///< of cx and cy, the larger
  double covered = 0;                ///< share of the picture's 8 x 6 fields that a corner fell into
  std::vector<ViewFit> views;        ///< those used
  std::vector<DroppedView> dropped;  ///< those that fit three times worse than the median
};

inline constexpr std::size_t kFewestViews = 6;

/// Fails  kInvalid: fewer than kFewestViews views, or a fit that cannot be a lens; says which pictures to add.
Result<LensFit> fit_lens(std::span<const BoardView> views, int width, int height);

/// Where the board is, for a known lens. Fails  kInvalid where the corners lie too badly to tell.
Result<ViewFit> locate_board(const BoardView& view, const CameraModel& model);

}  // namespace copresence::calibrate
