#pragma once

// Finds by rays which places of a figure a camera sees. Exact for every camera model, wherever the figure is.
//
// Only cells of pixels that spheres around the figure's parts cover are traced.
//
// Thread: one thread per object; several may share a world.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "simulation/figure_hits.h"
#include "simulation/sight.h"
#include "simulation/world.h"

namespace copresence::simulation {

class FigureRays {
 public:
  FigureRays(std::shared_ptr<const World> world, const Sight& sight);

  /// What of the figure is nearer than `walls`, the room's depth at each pixel's middle, 0 for none. `pose`: world
  /// from each part. Requires cleared hits, and the sight that the object was made with.
  void find(const Sight& sight, const Image<float>& walls, std::span<const Eigen::Isometry3f> pose,
            FigureHits& hits);

 private:
  struct Sphere {
    Eigen::Vector3f center;
    float radius = 0;
  };

  void bound_parts();
  void find_cells(const Sight& sight, std::span<const Eigen::Isometry3f> pose);
  template <class Visit>
  void for_each_run(std::size_t width, Visit&& visit) const;

  std::shared_ptr<const World> world_;
  PosedScene posed_;
  std::vector<std::vector<Sphere>> bounds_;  // per part, in its own frame: together they hold all of it
  Image<std::uint8_t> cells_;                // rows of cells in which the figure may be
  std::vector<Ray> rays_;
};

}  // namespace copresence::simulation
