#pragma once

// What a simulated camera is asked to be, as written:
// simulated:WORLD?camera=N&cameras=N&seed=N&marker=on&control=FILE &projectors=FILE
//
// Thread: values.

#include <cstdint>
#include <string>

#include "common/result.h"

namespace copresence::drivers {

inline constexpr const char* kSimulatedPrefix = "simulated:";

struct SimulatedUri {
  std::string world;       ///< as simulation::World::names() has it
  int camera = 0;          ///< which of simulation::kinect_poses()
  int cameras = 2;         ///< Kinects whose projectors shine into the room; at least camera + 1
  std::uint32_t seed = 1;  ///< of all noise
  bool marker = false;  ///< draws the frame's number into the colour picture, see simulation/frame_marker.h
  std::string control;  ///< a file that plugs the camera in and breaks it, see read_control(); empty for none
  std::string
      projectors;  ///< which of the room's projectors shine, see shared_projectors.h; empty: all, always
};

/// Fails  kInvalid, with a sentence that says what can stand there.
Result<SimulatedUri> parse_simulated_uri(const std::string& uri);

/// Which simulated cameras there are, for people: "simulated:WORLD?camera=N, N from 0 to 7, WORLD one of
/// room, ...".
std::string simulated_cameras();

/// What a control file wants of its camera: for tests of what happens when cameras fail.
enum class Control {
  kWork,       ///< the file is there (whatever else is in it), or none was named
  kUnplugged,  ///< no such file
  kStall,      ///< "stall": no frames, without a word
  kCrash,      ///< "crash": the driver ends its process
  kHang,       ///< "hang": the driver never returns
};
Control read_control(const std::string& path);

}  // namespace copresence::drivers
