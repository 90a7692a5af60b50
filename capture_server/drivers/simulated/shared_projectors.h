#pragma once

// Which projectors of a simulated world are on, shared between processes. Every camera of the world
// maps the same small file. The projector of a camera whose process has ended counts as off.
//
// Thread: any; only one process may write the entry of a camera.

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/result.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::drivers {

class SharedProjectors {
 public:
  /// Maps the file, and creates it if it does not exist.
  /// Fails  kUnavailable, with the name of the file.
  static Result<SharedProjectors> open(const std::string& path);
  ~SharedProjectors();
  SharedProjectors(SharedProjectors&& other) noexcept;
  SharedProjectors& operator=(SharedProjectors&&) = delete;

  /// Sets the state of a projector. Requires camera < simulation::kMostKinects.
  void set(std::size_t camera, bool is_on);
  simulation::Projectors on() const;

 private:
  explicit SharedProjectors(std::uint32_t* entries) : entries_(entries) {}

  std::uint32_t* entries_;  // per camera: the process if its projector is on, otherwise 0
};

}  // namespace copresence::drivers
