#pragma once

// The texture of a camera: for each pixel the corrected colour and the weight of its fragments.
// Red, green and blue are the colour. Alpha is cos(theta), times kFilledWeight for filled pixels. A
// camera without colour has the gray of shade_without_color().
//
// Thread: values; distinct ones are independent.

#include <Eigen/Core>
#include <cstdint>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"
#include "render_client/renderer/cpu/planar_blocks.h"

namespace copresence::renderer {

/// Computes cos(theta) for cells of kCell pixels (merge_rules.h). The normal of a planar block of
/// that size is known. Other cells are fitted to those of their pixels that have depth.
void measure_incidence(const InverseDepth& inverse, const PlanarBlocks& blocks, const CameraModel& camera,
                       Image<float>& incidences);

/// Red in the lowest byte, then green, blue and 255 cos(theta), which is at least 1. One column and
/// one row larger than the frame; they repeat the last ones. So a bilinear sample at the border
/// needs no clamping.
using CameraTexture = Image<std::uint32_t>;

void make_texture(const RgbdFrame& frame, const Image<float>& incidences,
                  const Eigen::Matrix<float, 3, 4>& color_correction, CameraTexture& texture);

}  // namespace copresence::renderer
