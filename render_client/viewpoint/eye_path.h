#pragma once

// A path of the eye, as people write it: `--view path:FILE` of render_client, `--truth FILE` of
// simulate_kinect.
//
// Lines `view x y z look_x look_y look_z`: from the view with that index on, the eye stands at x y z and
// looks at the point look. Positions are world coordinates in metres. Between two lines both points move
// linearly; before the first line and after the last the eye stands still. Indices rise. A # begins a
// comment; empty lines are allowed.
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
    Eigen::Vector3d eye, look;  ///< metres, apart from each other
  };

  /// Fails where there is no such file (kNotFound), and as parse() does.
  static Result<EyePath> load(const std::filesystem::path& path);

  /// `name` is what errors call the text. Fails with kInvalid, "NAME:LINE: what is wrong".
  static Result<EyePath> parse(std::string_view text, std::string_view name);

  Place at(std::uint64_t view) const;

 private:
  struct Stop {
    std::uint64_t view;
    Place place;
  };
  explicit EyePath(std::vector<Stop> stops) : stops_(std::move(stops)) {}

  std::vector<Stop> stops_;  // at least one, by view
};

}  // namespace copresence::viewpoint
