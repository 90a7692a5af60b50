#pragma once

// A scripted path of the eye, as `--view path:FILE` takes it: lines "view x y z look_x look_y look_z", linear
// between them, constant before the first and after the last. Metres in the world.

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "common/result.h"

namespace copresence::simulate_kinect {

class ViewPath {
 public:
  struct Stop {
    double view = 0;
    Eigen::Vector3d eye, look;
  };

  /// Fails  kNotFound when the file cannot be read, kInvalid (naming the line) for lines that make no sense.
  static Result<ViewPath> load(const std::filesystem::path& path);

  Stop at(double view) const;

 private:
  std::vector<Stop> stops_;  // ascending, one or more
};

}  // namespace copresence::simulate_kinect
