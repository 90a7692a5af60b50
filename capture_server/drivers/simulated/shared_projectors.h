#pragma once

// Which simulated projectors shine, between processes: real ones meet in the room's air, these in a small file that every
// camera of the room maps. A camera that nobody runs is dark, also where its process was killed.
//
// Thread: any; one process writes a camera's entry.

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/result.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::drivers {

class SharedProjectors {
 public:
  /// Makes the file where it is not there yet.
  /// Fails  kUnavailable, with the file's name.
  static Result<SharedProjectors> open(const std::string& path);
  ~SharedProjectors();
  SharedProjectors(SharedProjectors&& other) noexcept;
  SharedProjectors& operator=(SharedProjectors&&) = delete;

  /// Camera numbers are below simulation::kMostKinects.
  void set(std::size_t camera, bool shines);
  simulation::Projectors shining() const;

 private:
  explicit SharedProjectors(std::uint32_t* entries) : entries_(entries) {}

  std::uint32_t* entries_;  // kMostKinects of them: the process whose camera shines, 0 where it is dark
};

}  // namespace copresence::drivers
