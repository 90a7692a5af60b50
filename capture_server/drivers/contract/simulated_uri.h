#pragma once

// The address of a simulated camera, which the server parses and the driver opens:
// simulated:WORLD?camera=N&cameras=N&seed=N&marker=on&control=FILE&projectors=FILE
//
// The worlds and the number of cameras are listed here, so that the server need not link the
// simulator. A test compares the lists with the simulator's own.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::drivers {

inline constexpr const char* kSimulatedPrefix = "simulated:";
inline constexpr int kMostSimulatedCameras = 8;  ///< Number of cameras in one world.
inline constexpr std::array<std::string_view, 5> kSimulatedWorlds = {"room", "empty-room", "markers", "board",
                                                                     "still-board"};

struct SimulatedUri {
  std::string world;       ///< One of kSimulatedWorlds.
  int camera = 0;          ///< Index of this camera, below kMostSimulatedCameras.
  int cameras = 2;         ///< Number of Kinects whose projectors shine into the world; at least camera + 1.
  std::uint32_t seed = 1;  ///< Seed of all noise.
  bool marker = false;     ///< Draws the frame's number into the colour picture.
  std::string control;     ///< Path of a file by which tests make the camera fail, or empty.
  /// File by which cameras share the states of their projectors. Without this file all projectors
  /// are on.
  std::string projectors;
};

/// Fails with kInvalid and a sentence that lists the possible values.
Result<SimulatedUri> parse_simulated_uri(const std::string& uri);

/// All simulated cameras in one phrase: "simulated:WORLD?camera=N, N from 0 to 7, ...".
std::string simulated_cameras();

}  // namespace copresence::drivers
