#pragma once

// What a camera's fragments look like and what they are worth: one texel per pixel, r, g, b after colour
// matching, and in alpha cos(theta), times kFilledWorth for filled pixels. A camera without colour has the gray of its
// tilts. Private to the CPU renderer. Thread: values; distinct ones are independent.

#include <Eigen/Core>
#include <cstdint>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"
#include "render_client/renderer/cpu/flat_blocks.h"

namespace copresence::renderer {

/// cos(theta) by cell of kCell pixels (merge_rules.h): flat blocks of that size have it already, the other
/// cells are fitted to the pixels they have.
void measure_tilts(const InverseDepth& inverse, const FlatBlocks& blocks, const CameraModel& camera,
                   Image<float>& cosines);

/// r in the lowest byte, then g, b, and 255 cos(theta) from 1 up. One column and one row more than the frame,
/// the last ones repeated: a bilinear sample at the border needs no clamping.
using Texture = Image<std::uint32_t>;

void make_texture(const RgbdFrame& frame, const Image<float>& cosines,
                  const Eigen::Matrix<float, 3, 4>& color_matching, Texture& texture);

}  // namespace copresence::renderer
