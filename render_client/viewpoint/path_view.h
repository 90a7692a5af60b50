#pragma once

// A scripted eye, for repeatable views: `--view path:FILE`.
//
// Lines `view x y z look_x look_y look_z`: from the view with that index on the eye stands at x y z and looks
// at the point look, world metres; linear between the lines, still before the first and after the last.
// Indices rise. A # begins a comment; empty lines are fine.

#include <Eigen/Core>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class PathView final : public Viewpoint {
 public:
  /// `up` is the world's. Fails with kNotFound for a file that cannot be read and kInvalid, "FILE:LINE: what
  /// is wrong", for one that makes no sense.
  static Result<PathView> load(const std::filesystem::path& path, const Eigen::Vector3d& up);

  /// The same on a text; `name` is what errors call it.
  static Result<PathView> parse(std::string_view text, std::string_view name, const Eigen::Vector3d& up);

  Eye at(std::uint64_t view_index, Instant now) override;
  void set_home(const Rigid3&) override {}  // a path says it all

 private:
  struct Stop {
    std::uint64_t view;
    Eigen::Vector3d eye, look;
  };
  PathView(std::vector<Stop> stops, const Eigen::Vector3d& up) : stops_(std::move(stops)), up_(up) {}

  std::vector<Stop> stops_;  // at least one, by view
  Eigen::Vector3d up_;
};

}  // namespace copresence::viewpoint
