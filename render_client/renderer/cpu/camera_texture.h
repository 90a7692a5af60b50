#pragma once

// Makes the texture of a camera. Red, green and blue are the corrected colour of a pixel. Alpha is
// the weight of its fragments: cos(theta), times kFilledWeight for filled pixels. A camera without
// colour has a gray from shade_without_color(). Thread: different objects may be used at the same
// time.

#include <Eigen/Core>
#include <cstdint>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

/// Computes cos(theta) for cells of kCell pixels a side (merge_rules.h). Where a planar block of
/// this size exists, its plane is used. Other cells get a plane fitted to their pixels with depth.
void measure_incidence(const InverseDepth& inverse, const PlanarBlocks& blocks, const CameraModel& camera,
                       Image<float>& incidences);

/// Each texel has red in the lowest byte, then green, blue and alpha. Alpha is 255 times the
/// weight, and at least 1. It is 0 only for pixels that are left out (merge_rules.h).
/// The texture has one more column and row than the frame. They repeat the
/// last column and row, so that a bilinear sample at the border needs no clamping.
using CameraTexture = Image<std::uint32_t>;

void make_texture(const RgbdFrame& frame, const Image<float>& incidences,
                  const Eigen::Matrix<float, 3, 4>& color_correction, CameraTexture& texture);

}  // namespace copresence::renderer
