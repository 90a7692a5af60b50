#pragma once

// How far a library that keeps its file to itself has read.
//
// Thread: pure but for what the kernel tells.

#include <cstdint>

namespace copresence::sensor {

/// The sum of the positions, in bytes, of all other descriptors by which this process has the file of `descriptor` open; 0 where there
/// are none and where the kernel does not tell (/proc/self/fdinfo).
std::uint64_t read_position_beside(int descriptor);

}  // namespace copresence::sensor
