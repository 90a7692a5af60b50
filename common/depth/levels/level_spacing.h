#pragma once

// How many codes lie between depth levels: what `distance` of Codebook::assign is.
//
// Thread: pure.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/depth_unit.h"

namespace copresence::depth {

/// One code for each of a Kinect v1's steps (z² / 351.3 m), at least one between levels: as fine as the
/// sensor and no finer, which makes lossless coding cheapest. Source: thesis 3.3.3.2.
std::vector<double> sensor_spacing(std::span<const std::uint16_t> levels, DepthRangeUnits range,
                                   DepthUnit unit);

/// All codes for the depths that the scene has: levels with a good part of the pixels lie as many codes
/// apart, for every sensor step, as there is room for, up to kFinest; rare ones lie one code a step apart. A
/// finer code and a coarser quantiser cost the same bits, but H.264 then errs by fractions of a level: a
/// tenth less error at the same rate. `pixels` holds how many pixels each level has. Source: thesis 3.3.3.3
/// in purpose; the form is ours.
std::vector<double> scene_spacing(std::span<const std::uint16_t> levels,
                                  std::span<const std::uint32_t> pixels, DepthRangeUnits range,
                                  DepthUnit unit);

inline constexpr double kFinest = 4.0;  ///< codes a sensor step; finer ones gained nothing

}  // namespace copresence::depth
