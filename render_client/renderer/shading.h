#pragma once

// Surface normals for the shading of a camera without colour (merge_rules.h, Colour). Its gray
// comes from the normals alone, so their noise is all that one sees. The normals of single cells
// show the steps between depth levels as stripes.
//
// A cell's inverse depth is the mean of those of its pixels that lie within kShadedSurface of the
// nearest. A plane is then fitted to the cells around it, over a window that grows with depth as the
// noise does: one cell to each side per metre, at least kLeastRadius and at most kMostRadius. A cell
// d columns or rows away counts if it differs by at most d * kShadedSurface. Beyond kSharpM, the
// slopes of the planes are averaged over 3x3 cells by the same rule.
//
// Thread: pure functions.

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::renderer {

inline constexpr float kShadedSurface = 0.0228F;  ///< 1/m: 8 disparity steps of a Kinect v1
inline constexpr float kSharpM = 1.2F;
inline constexpr int kLeastRadius = 1, kMostRadius = 3;

/// Computes cos(theta) of each cell, as merge_rules.h defines it; kUnknownIncidence without depth.
void measure_shading(const DepthImage& depth, DepthUnit unit, const CameraModel& camera,
                     Image<float>& incidences);

}  // namespace copresence::renderer
