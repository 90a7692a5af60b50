#pragma once

// OpenNI2 for the sources of this module and for capture_server --list: its lifetime, its errors,
// its devices and frames as this project's types.

#include <OpenNI.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// OpenNI2 is initialised while one of these exists; OpenNI2 counts them itself. The first one
/// decides which camera drivers are active (drivers/contract/driver_choice.h) until the last one is
/// destroyed.
/// Thread: no other thread of the process reads or writes the environment while the first one is
/// made.
class OpenNiSession {
 public:
  explicit OpenNiSession(std::string_view drivers) : status_(initialize(drivers)) {}
  ~OpenNiSession() {
    if (status_ == openni::STATUS_OK) openni::OpenNI::shutdown();
  }
  OpenNiSession(const OpenNiSession&) = delete;
  OpenNiSession& operator=(const OpenNiSession&) = delete;

  bool is_up() const { return status_ == openni::STATUS_OK; }

 private:
  static openni::Status initialize(std::string_view drivers);

  openni::Status status_;
};

/// Call between stopping streams and destroying them: a thread of the driver may still be inside
/// them. Waits until the threads of this process had 50 ms of CPU time to leave, at most 400 ms.
void let_threads_leave();

/// OpenNI2's message about its last error, on one line; "no reason given" if it has none.
std::string last_open_ni_error();

/// Whether frames of a mode can be used: depth in 1 mm or 0.1 mm, colour in RGB888, of even size.
bool is_usable(const openni::VideoMode& mode, bool is_depth);

/// The usable mode that is nearest to the requested size, then to 30 frames a second; 1 mm is
/// preferred to 0.1 mm.
std::optional<openni::VideoMode> choose_mode(const openni::SensorInfo& sensor, bool is_depth, int width,
                                             int height);

/// From the device's intrinsics, else from its field of view, else a Kinect's.
CameraModel camera_of(const openni::VideoStream& stream);

/// world_from_camera, if the device knows it.
std::optional<Rigid3> pose_of(const openni::Device& device);

/// Every depth that the stream can report, ascending, from its table of disparities; empty if it
/// has none.
std::vector<std::uint16_t> levels_of(const openni::VideoStream& depth);

/// Whether a frame has the size that its stream advertised: OpenNI2 also delivers truncated ones.
bool is_whole(const openni::VideoFrameRef& frame, const CameraModel& camera, int bytes_per_pixel);

/// Copies the pictures out. Requires is_whole() of both, with 2 and 3 bytes per pixel.
void copy_depth(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);
void copy_color(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);

}  // namespace copresence::sensor
