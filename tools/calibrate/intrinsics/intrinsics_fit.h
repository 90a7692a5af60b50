#pragma once

// Fits a camera's intrinsics to views of a board: focal lengths, principal point and OpenCV's
// rational distortion (thesis 2.5.1, eq. 2.4). Also finds the pose of a board for known intrinsics.
// Thread: pure functions.

#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/intrinsics/board.h"

namespace copresence::calibrate {

struct ViewFit {
  std::string picture;
  double rms_px = 0;         ///< Reprojection error.
  Rigid3 camera_from_board;  ///< Pose of the board, metres.
};

struct IntrinsicsFit {
  CameraModel model;
  std::string distortion;      ///< Names of the coefficients that were fitted; the others are 0.
  int distortion_terms = 0;    ///< Number of coefficients that were fitted: 0, 4, 5 or 8.
  double rms_px = 0;           ///< Reprojection error over all views.
  double focal_sigma_px = 0;   ///< OpenCV's standard deviation of fx or fy, whichever is larger.
  double center_sigma_px = 0;  ///< Standard deviation of cx or cy, whichever is larger.
  double covered = 0;          ///< Share of the picture's 8 x 6 cells with a corner.
  std::vector<ViewFit> views;
  std::vector<DroppedView> dropped;  ///< Unused views: their error is over three times the median.
};

inline constexpr std::size_t kFewestViews = 6;

/// Largest errors of a good fit and of an accepted fit, for pictures up to kUsualWidth wide. These
/// limits grow in proportion for wider pictures.
inline constexpr double kGoodRmsPx = 0.3, kMostRmsPx = 1.0, kUsualWidth = 1280;
/// Largest accepted standard deviations: of a focal length relative to itself, and of the principal
/// point relative to the picture's longer side.
inline constexpr double kMostFocalSigma = 0.01, kMostCenterSigma = 0.01;

/// The fit's rms_px relative to kGoodRmsPx at the picture's size. Up to 1 is good.
double times_good_rms(const IntrinsicsFit& fit);

/// Fails with kInvalid for fewer than kFewestViews views, or if the error or the uncertainty is
/// above the limits. The message names the likely cause: views of two cameras, a board that is
/// hardly tilted or small, a wrong board size, or a fisheye lens.
Result<IntrinsicsFit> fit_intrinsics(std::span<const BoardView> views, int width, int height);

/// Finds the pose of the board for known intrinsics. Fails with kInvalid if the corners do not
/// determine it.
Result<ViewFit> locate_board(const BoardView& view, const CameraModel& model);

}  // namespace copresence::calibrate
