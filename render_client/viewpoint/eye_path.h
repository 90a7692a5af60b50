#pragma once

// A scripted path of the eye: `--view path:FILE` of render_client, `--truth FILE` of
// simulate_kinect.
//
// The text has lines `view x y z look_x look_y look_z`. From the view with index `view` on, the eye
// is at x y z and looks at the point look. Positions are world coordinates in metres. Both points
// move linearly between two lines. Before the first line and after the last the eye stays. Indices
// must rise. A # begins a comment; empty lines are allowed.
//
// Thread: values.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::viewpoint {

class EyePath {
 public:
  struct Place {
    Eigen::Vector3d eye, look;  ///< metres; the two points differ
  };

  /// Fails with kNotFound if there is no such file, and as parse().
  static Result<EyePath> load(const std::filesystem::path& path);

  /// `name` is the name of the text in errors. Fails with kInvalid and "NAME:LINE: what is wrong".
  static Result<EyePath> parse(std::string_view text, std::string_view name);

  Place at(std::uint64_t view) const;

 private:
  struct Stop {
    std::uint64_t view;
    Place place;
  };
  explicit EyePath(std::vector<Stop> stops) : stops_(std::move(stops)) {}

  std::vector<Stop> stops_;  // at least one, by rising view
};

}  // namespace copresence::viewpoint
