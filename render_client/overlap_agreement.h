#pragma once

// Measures how well a camera agrees with the others: the distances between the surfaces that several
// cameras measure at the same point. They contain the sensors' noise and the errors of the poses.
// Thread: pure functions.

#include <optional>
#include <span>

#include "render_client/camera_setup/camera_setup.h"

namespace copresence::client {

/// A greater distance means that the cameras see different surfaces. It is ignored.
inline constexpr double kSameSurfaceM = 0.1;

/// Returns the median distance in millimetres between measured pixels of `camera` and the surfaces of
/// `others`, along the axes of the others. A sparse grid of pixels is compared, which takes a
/// fraction of a millisecond for each other camera. Returns nothing if fewer than 50 pixels overlap.
/// Requires that all cameras have poses.
std::optional<double> median_disagreement_mm(const CameraFrame& camera,
                                             std::span<const CameraFrame* const> others);

}  // namespace copresence::client
