#pragma once

// What every user of OpenNI2 in this room needs: its lifetime, its errors, its frames as ours. Only for this
// room's own sources.

#include <OpenNI.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// OpenNI2 is up while one of these lives; it counts them itself. The first one decides which camera drivers work
/// (drivers/contract/driver_choice.h) until the last one goes.
/// Thread: the first one is made while no other thread of the process reads or writes the environment.
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

/// Call between stopping streams and destroying them: a thread of the driver, or of the player of recordings, may still be
/// inside. It has 50 ms of a core to leave, or 400 ms at most.
void let_threads_leave();

/// OpenNI2's own words about its last error, on one line; "no reason given" where it has none.
std::string last_open_ni_error();

/// Every depth that a stream can have, ascending, from its table of disparities; empty where it has none.
std::vector<std::uint16_t> levels_of(const openni::VideoStream& depth);

/// Whether a frame is what its stream promised: OpenNI2 hands on short and odd ones.
bool is_whole(const openni::VideoFrameRef& frame, const CameraModel& camera, int bytes_per_pixel);

/// Copies the pictures out. Requires is_whole() of both, 2 and 3 bytes a pixel.
void copy_depth(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);
void copy_color(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into);

}  // namespace copresence::sensor
