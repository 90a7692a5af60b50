#pragma once

// The address of a simulated camera, as the server reads it and the driver opens it:
// simulated:WORLD?camera=N&cameras=N&seed=N&marker=on&control=FILE&projectors=FILE
//
// The worlds and the number of cameras are listed here so that the server need not link the
// simulator. A test holds the lists to the simulator's own.
//
// Thread: values.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::drivers {

inline constexpr const char* kSimulatedPrefix = "simulated:";
inline constexpr int kMostSimulatedCameras = 8;  ///< in one world
inline constexpr std::array<std::string_view, 5> kSimulatedWorlds = {"room", "empty-room", "markers", "board",
                                                                     "still-board"};

struct SimulatedUri {
  std::string world;       ///< one of kSimulatedWorlds
  int camera = 0;          ///< index of this camera, below kMostSimulatedCameras
  int cameras = 2;         ///< Kinects whose projectors shine into the room; at least camera + 1
  std::uint32_t seed = 1;  ///< of all noise
  bool marker = false;     ///< draws the frame's number into the colour picture
  std::string control;     ///< a file whose content makes the camera fail, for tests; empty for none
  std::string projectors;  ///< a file that cameras share to switch their projectors; empty: all are always on
};

/// Fails  kInvalid, with a sentence that lists the possible values.
Result<SimulatedUri> parse_simulated_uri(const std::string& uri);

/// All simulated cameras in one phrase: "simulated:WORLD?camera=N, N from 0 to 7, WORLD one of
/// room, ...".
std::string simulated_cameras();

}  // namespace copresence::drivers
