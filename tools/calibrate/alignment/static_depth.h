#pragma once

// What a still camera saw all along: the mean depth of many frames, without what moved.
//
// A Kinect's errors are of its disparity, so is the mean: it is taken over 1/z.
//
// Thread: pure.

#include <span>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::alignment {

/// Metres along the optical axis, 0 = none. A pixel has a depth where at least half of the frames measured one and
/// four fifths of these lie within 2.5 sensor steps of their median; else something moved there, or the sensor
/// could not decide.
///
/// frames  at least one, of one size, in `unit`; 0 is a hole.
Image<float> static_depth(std::span<const DepthImage> frames, DepthUnit unit);

/// Share of all pixels in which depth was measured, mean over the frames.
double measured_share(std::span<const DepthImage> frames);

/// Share of the pixels that at least half of the frames measured and that all the same have none in `mean`, which
/// static_depth() made of these frames: what moved, and the rims at which a sensor cannot decide.
double unsteady_share(std::span<const DepthImage> frames, const Image<float>& mean);

}  // namespace copresence::alignment
