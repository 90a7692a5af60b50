#pragma once

// Camera models of cameras that were not calibrated. Sensors have square pixels.
//
// Thread: free functions on values, safe anywhere.

#include "common/frame/camera_model.h"

namespace copresence {

/// A camera of which only its size is known: a Kinect v1's nominal field of view, 58.1 degrees, along the longer side, and
/// square pixels. At 640x480 that is fx = fy = 575.8.
CameraModel nominal_kinect(int width, int height);

/// A sensor's or a recording's own field of view, radians. Many report the angles of their 4:3 mode in every mode: where
/// the two angles would make pixels more than 5 % out of square, that of the longer side counts.
CameraModel camera_of_sensor(int width, int height, double horizontal, double vertical);

}  // namespace copresence
