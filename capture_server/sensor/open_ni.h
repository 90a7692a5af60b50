#pragma once

// OpenNI2 for this module and for capture_server --list: its lifetime and errors, and the
// conversion of its devices and frames to this project's types.

#include <OpenNI.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// OpenNI2 is initialised while at least one object of this class exists. The first object decides
/// until the last one is destroyed which camera drivers are active (driver_choice.h).
/// Thread: while the first object is created, no other thread may read or write the environment.
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

/// Gives the driver's threads time to leave the streams of a device. It waits until this process's
/// threads had 50 ms of CPU time, at most 400 ms. Call this function between stopping and
/// destroying streams.
void let_threads_leave();

/// OpenNI2's message about its last error on one line, or "no reason given".
std::string last_open_ni_error();

/// True if frames of the mode can be used: depth in 1 mm or 0.1 mm, colour in RGB888, of even size.
bool is_usable(const openni::VideoMode& mode, bool is_depth);

/// The usable mode that is nearest to the requested size, then to 30 frames a second. A mode in 1
/// mm is preferred to one in 0.1 mm.
std::optional<openni::VideoMode> choose_mode(const openni::SensorInfo& sensor, bool is_depth, int width,
                                             int height);

/// The stream's camera model, from the device's intrinsics or its field of view. The default model
/// is a Kinect's.
CameraModel camera_of(const openni::VideoStream& stream);

/// The pose world_from_camera. Returns nothing if the device does not know its pose.
std::optional<Rigid3> pose_of(const openni::Device& device);

/// Every depth that the stream can report, ascending, from its table of disparities. The result is
/// empty if the stream has no table.
std::vector<std::uint16_t> levels_of(const openni::VideoStream& depth);

/// True if a frame has the size that its stream advertised. OpenNI2 also delivers truncated frames.
bool is_whole(const openni::VideoFrameRef& frame, const CameraModel& camera, int bytes_per_pixel);

/// Copies a picture. Requires is_whole(), with 2 bytes per pixel for depth and 3 for colour.
void copy_depth(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);
void copy_color(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);

}  // namespace copresence::sensor
