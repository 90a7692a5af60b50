#pragma once

// Shares between processes which projectors of a simulated world are on. Every camera of the world
// maps the same small file. If a camera's process has ended, its projector counts as off.
// Thread: any thread; only one process may write a camera's entry.

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/result.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::drivers {

class SharedProjectors {
 public:
  /// Maps the file, and creates it if it does not exist.
  /// Fails with kUnavailable and the name of the file.
  static Result<SharedProjectors> open(const std::string& path);
  ~SharedProjectors();
  SharedProjectors(SharedProjectors&& other) noexcept;
  SharedProjectors& operator=(SharedProjectors&&) = delete;

  /// Sets the state of a projector. Requires camera < simulation::kMostKinects.
  void set(std::size_t camera, bool is_on);
  simulation::Projectors on() const;

 private:
  explicit SharedProjectors(std::uint32_t* entries) : entries_(entries) {}

  std::uint32_t* entries_;  // Per camera: the id of its process while its projector is on, else 0.
};

}  // namespace copresence::drivers
