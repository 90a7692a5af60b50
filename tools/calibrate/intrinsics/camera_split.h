#pragma once

// Detects views of two cameras among views that should come from one. Thread: pure functions.
// The reprojection error does not reveal two cameras, because wrong distances of the boards
// compensate for much of a wrong focal length. Views of fx 580 and fx 550 fit one camera to 0.17
// px; views of a single camera fit to 0.14 px. But the views form two groups that each fit one
// camera.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tools/calibrate/intrinsics/intrinsics_fit.h"

namespace copresence::calibrate {

struct CameraSplit {
  std::vector<std::size_t> first, second;  ///< Indices of the views of each camera.
  CameraModel first_model, second_model;
};

/// Splits the views into two groups that fit different cameras. Returns nothing if one camera fits
/// as well.
///
/// The method fits a mixture of two cameras, linearised at the joint fit, with the boards' poses
/// eliminated. From many starts, it alternates between assigning views and solving for both
/// cameras. For the best result, the method then fits a camera to each group without linearisation.
///
/// A split must pass three tests. Schwarz's criterion prefers two cameras. The focal lengths or
/// principal points differ by more than their uncertainty. The parameters of the two cameras differ
/// much more than those of the views in a group. A bent board fails this last test.
///
/// `joint` is the fit of all `views` by one camera, in the same order.
/// `fit_group` fits a camera with the same distortion coefficients to some views, from `start`.
using FitGroup = std::function<Result<IntrinsicsFit>(std::span<const BoardView>, const CameraModel& start)>;
std::optional<CameraSplit> find_two_cameras(std::span<const BoardView> views, const IntrinsicsFit& joint,
                                            const FitGroup& fit_group);

}  // namespace copresence::calibrate
