#pragma once

// A scripted path of the eye (render_client --view path:FILE, simulate_kinect --truth FILE).
//
// Each line of the file is `view x y z look_x look_y look_z`. At the view with the index `view`,
// the eye is at (x, y, z) and looks at the point (look_x, look_y, look_z). Positions are world
// coordinates in metres. Between two lines, both points are interpolated linearly. Before the first
// line and after the last line, the eye does not move. Indices must rise. A # begins a comment.
// Empty lines are allowed. Thread: different objects may be used at the same time.

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
    Eigen::Vector3d eye, look;  ///< Metres. The two points differ.
  };

  /// Fails with kNotFound if the file does not exist, and otherwise as parse() does.
  static Result<EyePath> load(const std::filesystem::path& path);

  /// `name` is the text's name in error messages. Fails with kInvalid and a message of the form
  /// "NAME:LINE: what is wrong".
  static Result<EyePath> parse(std::string_view text, std::string_view name);

  Place at(std::uint64_t view) const;

 private:
  struct Stop {
    std::uint64_t view;
    Place place;
  };
  explicit EyePath(std::vector<Stop> stops) : stops_(std::move(stops)) {}

  std::vector<Stop> stops_;  // At least one stop, ordered by view.
};

}  // namespace copresence::viewpoint
