#pragma once

// Computes surface normals for the shading of a camera without colour (merge_rules.h, Colour). The
// gray depends on the normals alone, so their noise is clearly visible. Normals of single cells
// would show the steps between depth levels as stripes.
//
// On one surface, the inverse depths w of neighbouring cells differ by at most the limit
// kShadedSurface + kShadedSlope w. The inverse depth of a cell is the mean over its pixels that
// differ from its nearest pixel by at most this limit. Then a plane is fitted to the cells in a
// window around it. The window grows with depth, as the noise does. Its radius is one cell per
// metre, from kLeastRadius to kMostRadius. A cell at a distance of d cells is included if its
// inverse depth differs by at most d times the limit. Beyond kSharpM, the slopes of the planes are
// averaged over 3x3 cells by the same rule.
//
// Thread: pure functions.

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::renderer {

inline constexpr float kShadedSurface = 0.0228F;  ///< In 1/m; 8 disparity steps of a Kinect v1.
inline constexpr float kShadedSlope = 0.05F;      ///< Slope per cell at a tilt of 75 degrees.
inline constexpr float kSharpM = 1.2F;
inline constexpr int kLeastRadius = 1, kMostRadius = 3;

/// Computes cos(theta) of each cell (merge_rules.h). A cell without depth gets kUnknownIncidence.
void measure_shading(const DepthImage& depth, DepthUnit unit, const CameraModel& camera,
                     Image<float>& incidences);

}  // namespace copresence::renderer
