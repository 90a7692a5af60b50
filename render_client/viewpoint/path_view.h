#pragma once

// A scripted eye, for repeatable views: `--view path:FILE` (eye_path.h).

#include <Eigen/Core>

#include "render_client/viewpoint/eye_path.h"
#include "render_client/viewpoint/look_at.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class PathView final : public Viewpoint {
 public:
  /// `up` is the world's.
  PathView(EyePath path, const Eigen::Vector3d& up) : path_(std::move(path)), up_(up) {}

  Eye at(std::uint64_t view_index, Instant) override {
    const EyePath::Place place = path_.at(view_index);
    return {look_at(place.eye, place.look, up_)};
  }
  void set_home(const Rigid3&) override {}  // a path says it all

 private:
  EyePath path_;
  Eigen::Vector3d up_;
};

}  // namespace copresence::viewpoint
