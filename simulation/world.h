#pragma once

// A place with a figure in it, lit and ready for rays.
//
// The world's frame is x right, y down, z forward; the floor is at y = 0, the figure stands at the origin and
// faces -z. Motion is periodic: `phase` counts periods, and phase 1 is phase 0 again. At 30 frames a second a
// period is kPeriodFrames.
//
// Thread: immutable once made; share it freely.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "simulation/figure.h"
#include "simulation/furnishing.h"
#include "simulation/light.h"
#include "simulation/ray_scene.h"

namespace copresence::simulation {

inline constexpr int kPeriodFrames = 60;

/// Phase of frame `frame` (from 0) in a recording of `frames` frames that is to loop without a seam: the
/// figure's period is stretched so that a whole number of them fills the recording. Requires frames > 0.
double phase_of_frame(std::uint64_t frame, std::uint64_t frames);

class World {
 public:
  /// One of names().
  /// Fails  kInvalid for another name, kUnsupported when the ray caster cannot start.
  static Result<World> make(std::string_view name);
  static std::vector<std::string> names();

  /// A world of one's own. `figure` may be empty.
  static Result<World> of(Furnishing furnishing, Figure figure = {});

  const Furnishing& furnishing() const { return furnishing_; }
  const Figure& figure() const { return figure_; }
  const RayScene& still() const { return *still_; }
  const PosedScene::Parts& parts() const { return *parts_; }
  const BakedLight& light() const { return light_; }

 private:
  Furnishing furnishing_;
  Figure figure_;
  std::shared_ptr<const RayScene> still_;
  std::shared_ptr<const PosedScene::Parts> parts_;
  BakedLight light_;
};

}  // namespace copresence::simulation
